//! `cargo xtask bench colors`: how near coarse meshes of painted models are, in place and in colour, beside simplification
//! that weighs colours.

use std::error::Error;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use fcbuild::BuildOptions;
use fcbuild::import::{Group, Positions, Soup, Tally};
use fcextract::{Budget, Extraction, Selection, fit};
use fcmeasure::{Distance, Reference, Surface};
use fct::{Tree, WriteOptions};
use glam::{DVec3, Vec3};

use super::input::{Input, paths};
use super::ledger::{self, Entry};
use super::peers::keep_colors;
use super::table::{Table, three};
use super::targets::Size;
use crate::data::noise::{octaves, value};

const EXAMPLES: &str = "\
Examples:
  cargo xtask bench colors                      the sample meshes
  cargo xtask bench colors --scans ~/stanford   and bunny, armadillo and dragon
  cargo xtask bench colors --sizes 5000 a.ply   one mesh, one number of triangles
  cargo xtask bench colors --append my-laptop   keep the figures

Every mesh is painted with patches, thin lines and soft shades. RMS is the symmetric surface
distance in 1e-4 of the bounding box's diagonal; colour is the same mean over what the colours
of nearest places differ, in percent of black against white.
  plain       a tree that does not look at colours (--color-weight 0)
  simplify    meshoptimizer with the input's vertices, by places alone
  with        the same, weighing colours: of five weights the one whose two errors have the least product
A ratio is ours over that last one's at the same number of triangles.

It fails when a cut is over its number, or full resolution is not the input.";

/// What `cargo xtask bench colors` is told.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// Meshes, whose own colours do not count [default: the samples in data/, and the scans of --scans]
    #[arg(value_name = "MESH")]
    meshes: Vec<PathBuf>,
    /// Folder with bunny.ply, armadillo.ply and dragon.ply of the Stanford 3D Scanning Repository
    #[arg(long, env = "FCT_DATA", value_name = "DIR")]
    scans: Option<PathBuf>,
    /// How much colours count in the tree
    #[arg(long, value_name = "W", default_value_t = BuildOptions::default().color_weight)]
    color_weight: f64,
    /// Numbers of triangles, or shares of the faces; those above half of a mesh are left out
    #[arg(long, value_name = "N,..", value_delimiter = ',', default_value = "1000,5000,10%", value_parser = Size::parse)]
    sizes: Vec<Size>,
    /// Samples on either surface
    #[arg(long, value_name = "N", default_value_t = 100_000, value_parser = clap::value_parser!(u32).range(1_000..=10_000_000))]
    samples: u32,
    /// Append the figures to docs/benchmarks/MACHINE/DATE.csv
    #[arg(long, value_name = "MACHINE")]
    append: Option<String>,
}

/// Weights of a full step of a channel, against the size of the mesh, that the peer is tried with.
const PEER_WEIGHTS: [f32; 5] = [0.003, 0.01, 0.03, 0.1, 0.3];

/// One number of triangles of one mesh.
#[derive(Debug)]
struct Row {
    mesh: String,
    size: String,
    triangles: u64,
    ours: Distance,
    plain: Distance,
    simplified: Distance,
    weighed: Distance,
    diagonal: f64,
}

/// Measures and prints.
///
/// # Errors
/// When something cannot be run, or an answer is wrong.
pub(crate) fn run(args: &Args) -> Result<(), Box<dyn Error>> {
    let (mut rows, mut wrong) = (Vec::new(), Vec::new());
    for path in paths(&args.meshes, args.scans.as_deref())? {
        measure(&path, args, &mut rows, &mut wrong)?;
    }
    let mut out = std::io::stdout().lock();
    table(&rows).print(&mut out)?;
    if let Some(machine) = &args.append {
        writeln!(out, "appended to {}", ledger::append(machine, &entries(&rows, args))?.display())?;
    }
    if wrong.is_empty() { Ok(()) } else { Err(format!("wrong answers:\n  {}", wrong.join("\n  ")).into()) }
}

/// A mesh with colours.
struct Painted {
    positions: Vec<[f32; 3]>,
    faces: Vec<[u32; 3]>,
    colors: Vec<[u8; 4]>,
}

impl Painted {
    fn surface(&self) -> Surface<'_> {
        Surface { positions: &self.positions, faces: &self.faces, colors: &self.colors }
    }

    fn with_faces(&self, faces: Vec<[u32; 3]>) -> Painted {
        // Only vertices that are used may be measured.
        let mut place = vec![u32::MAX; self.positions.len()];
        let mut part = Painted { positions: Vec::new(), faces: Vec::new(), colors: Vec::new() };
        part.faces = faces
            .iter()
            .map(|face| {
                face.map(|v| {
                    let slot = &mut place[v as usize];
                    if *slot == u32::MAX {
                        *slot = part.positions.len() as u32;
                        part.positions.push(self.positions[v as usize]);
                        part.colors.push(self.colors[v as usize]);
                    }
                    *slot
                })
            })
            .collect();
        part
    }

    fn tree(&self, color_weight: f64) -> Result<Tree, Box<dyn Error>> {
        let soup = Soup {
            positions: Positions::F32(self.positions.clone()),
            triangles: self.faces.clone(),
            normals: None,
            colors: Some(self.colors.clone()),
            groups: vec![Group { name: "painted".to_owned(), triangles: 0..self.faces.len() }],
            tally: Tally::default(),
        };
        let built = fcbuild::build(soup, &BuildOptions { color_weight, ..BuildOptions::default() })?;
        let folder = tempfile::tempdir()?;
        let path = folder.path().join("tree.fct");
        fct::write(&path, &built.data(), &WriteOptions { overwrite: true, source_id: 0 })?;
        Ok(Tree::open(&path)?)
    }
}

/// What a place of the unit cube is painted with: patches with sharp borders and lines on a soft ground.
fn paint(p: DVec3) -> [u8; 4] {
    let byte = |x: f64| (255.0 * x.clamp(0.0, 1.0)).round() as u8;
    if octaves(p * 6.0, 2, 31) > 0.35 {
        return [170, 40, 30, 255];
    }
    if value(p * 5.0, 47).abs() < 0.04 {
        return [25, 25, 35, 255];
    }
    let soft = 0.15 * value(p * 3.0, 5);
    [byte(0.8 + soft), byte(0.75 + 0.2 * value(p * 2.0, 11)), byte(0.6 - soft), 255]
}

fn painted(input: Input) -> Painted {
    let positions = input.mesh.positions;
    let corners = positions.iter().map(|p| Vec3::from_array(*p).as_dvec3());
    let (low, high) = corners
        .clone()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
    let size = (high - low).max_element();
    let colors = corners.map(|p| paint((p - low) / size)).collect();
    Painted { positions, faces: input.mesh.faces, colors }
}

fn measure(
    path: &Path,
    args: &Args,
    rows: &mut Vec<Row>,
    wrong: &mut Vec<String>,
) -> Result<(), Box<dyn Error>> {
    let input = Input::read(path, [0.0; 3])?;
    let name = input.name.clone();
    eprintln!("{name}: building");
    let model = painted(input);
    let [tree, plain] = [model.tree(args.color_weight)?, model.tree(0.0)?];
    let reference = Reference::new(model.surface(), args.samples as usize);
    let whole = reference.distance(within(&tree, u64::MAX)?.1.surface());
    if whole.max > 1e-6 * reference.diagonal() || whole.color_rms.is_none_or(|c| c > 1e-3) {
        wrong.push(format!("{name}: full resolution is not the input: {whole:?}"));
    }
    let mesh = format!("{name} ({} faces)", model.faces.len());
    let sizes = args.sizes.iter().map(|s| (s.to_string(), s.of(model.faces.len())));
    for (size, n) in sizes.filter(|(_, n)| *n <= model.faces.len() as u64 / 2) {
        eprintln!("{mesh}: {size} triangles");
        let of = |mesh: &Painted| reference.distance(mesh.surface());
        let ours = within(&tree, n)?;
        if ours.0 > n {
            wrong.push(format!("{name}: {} triangles where at most {n} were asked for", ours.0));
        }
        let plain_mesh = within(&plain, n)?.1;
        let by = |weight: f32| {
            model.with_faces(keep_colors(&model.positions, &model.faces, &model.colors, weight, ours.0))
        };
        let product = |d: &Distance| d.rms * d.color_rms.unwrap_or(f64::INFINITY);
        let weighed = PEER_WEIGHTS.map(|weight| of(&by(weight)));
        let weighed = weighed.into_iter().min_by(|a, b| product(a).total_cmp(&product(b)));
        rows.push(Row {
            mesh: mesh.clone(),
            size,
            triangles: ours.0,
            ours: of(&ours.1),
            plain: of(&plain_mesh),
            simplified: of(&by(0.0)),
            weighed: weighed.unwrap_or(Distance { rms: f64::NAN, max: f64::NAN, color_rms: None }),
            diagonal: reference.diagonal(),
        });
    }
    Ok(())
}

/// The finest mesh of at most so many triangles, and how many are drawn.
fn within(tree: &Tree, triangles: u64) -> Result<(u64, Painted), Box<dyn Error>> {
    let mut cut = Extraction::default();
    let selection = fit(tree, Selection::by_budget(), Budget::Triangles(triangles), &mut cut)?.0;
    let mut mesh = fcextract::Mesh::default();
    mesh.fill(tree, &cut, &selection)?;
    let faces = mesh.indices.as_chunks::<3>().0.to_vec();
    Ok((cut.stats.triangles, Painted { positions: mesh.positions, faces, colors: mesh.colors }))
}

fn table(rows: &[Row]) -> Table {
    let heading = [
        "mesh",
        "size",
        "triangles",
        "RMS",
        "colour",
        "plain",
        "colour",
        "simplify",
        "colour",
        "with",
        "colour",
        "RMS ratio",
        "colour ratio",
    ];
    let mut table = Table::new(&heading);
    for row in rows {
        let mut cells = vec![row.mesh.clone(), row.size.clone(), row.triangles.to_string()];
        for distance in [&row.ours, &row.plain, &row.simplified, &row.weighed] {
            cells.push(three(1e4 * distance.rms / row.diagonal));
            cells.push(three(100.0 * color(distance)));
        }
        cells.push(three(row.ours.rms / row.weighed.rms));
        cells.push(three(color(&row.ours) / color(&row.weighed)));
        table.row(cells);
    }
    table
}

fn color(distance: &Distance) -> f64 {
    distance.color_rms.unwrap_or(f64::NAN)
}

fn entries(rows: &[Row], args: &Args) -> Vec<Entry> {
    let how = format!("cargo xtask bench colors, {} samples each way", args.samples);
    let entry = |row: &Row, what: &str, unit, value: &dyn Fn(&Distance) -> f64| {
        let all = [&row.ours, &row.plain, &row.simplified, &row.weighed].map(|d| three(value(d)));
        Entry {
            what: format!("{what}, facetree : without colours : meshopt simplify : with colours"),
            input: format!("painted {}", row.mesh),
            setting: format!("weight {}; size {}, {} triangles", args.color_weight, row.size, row.triangles),
            value: all.join(" : "),
            unit,
            how: how.clone(),
        }
    };
    rows.iter()
        .flat_map(|row| {
            [
                entry(row, "RMS distance", "1e-4 of the diagonal", &|d| 1e4 * d.rms / row.diagonal),
                entry(row, "RMS difference of colour", "% of black to white", &|d| 100.0 * color(d)),
            ]
        })
        .collect()
}

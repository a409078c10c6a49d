//! `cargo xtask bench culling`: how much the bounds of a tree let a viewer leave out, against those of the paper's tree.

use std::error::Error;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use fct::Tree;

use super::builder::Builder;
use super::cut::{Culls, Cut};
use super::input::paths;
use super::ledger::{self, Entry};
use super::orbit::{self, Visits};
use super::table::{Table, three};

const EXAMPLES: &str = "\
Examples:
  cargo xtask bench culling                        the sample meshes
  cargo xtask bench culling --scans ~/stanford     and bunny, armadillo and dragon
  cargo xtask bench culling --split cca bunny.ply  one mesh, another way to split
  cargo xtask bench culling --append my-laptop     keep the figures

Cuts of equally many clusters, the largest budget keys refined first:
  sphere      cross-sections of all bounding spheres over the area of the clusters
  half angle  mean of the normal cones, in degrees
  kept        share of the area turned away that cones do not cull, over directions all around
  overdraw    projected area of the bounding polygons over that of the faces in them that look
              at the viewer, over directions all around, for clusters that cones do not cull
And nodes visited and triangles drawn, at one pixel, summed over the views of a path around the
mesh. A ratio is that of the tree over the paper's tree; less is better, ! marks more than 1.15.

It fails when an answer is wrong: a cut that does not cover the mesh once, a face outside the
sphere, the cone or the polygon of its cluster.";

/// The largest ratio that is wanted.
const LIMIT: f64 = 1.15;

/// What `cargo xtask bench culling` is told.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// Meshes [default: the samples in data/, and the scans of --scans]
    #[arg(value_name = "MESH")]
    meshes: Vec<PathBuf>,
    /// Folder with bunny.ply, armadillo.ply and dragon.ply of the Stanford 3D Scanning Repository
    #[arg(long, env = "FCT_DATA", value_name = "DIR")]
    scans: Option<PathBuf>,
    /// How fcbuild splits the tree that is compared [default: as fcbuild does by itself]
    #[arg(long, value_name = "MODE")]
    split: Option<String>,
    /// Numbers of clusters; those above a quarter of the faces are left out
    #[arg(long, value_name = "N,..", value_delimiter = ',', default_value = "1000,10000,100000", value_parser = clap::value_parser!(u32).range(2..))]
    clusters: Vec<u32>,
    /// A fcbuild to measure [default: that of this workspace, built first]
    #[arg(long, value_name = "PROGRAM")]
    fcbuild: Option<PathBuf>,
    /// Append the figures to docs/benchmarks/MACHINE/DATE.csv
    #[arg(long, value_name = "MACHINE")]
    append: Option<String>,
}

/// One figure of both trees.
#[derive(Debug)]
struct Row {
    mesh: String,
    at: String,
    what: &'static str,
    paper: f64,
    other: f64,
}

impl Row {
    fn ratio(&self) -> f64 {
        // Nothing of both is the same.
        if self.paper == self.other { 1.0 } else { self.other / self.paper }
    }
}

/// Measures and prints.
///
/// # Errors
/// When something cannot be run, or an answer is wrong.
pub(crate) fn run(args: &Args) -> Result<(), Box<dyn Error>> {
    let program = args.fcbuild.as_deref();
    let other = Builder::new(program, args.split.as_deref())?;
    let paper = Builder::new(program, Some("paper"))?;
    let (mut rows, mut wrong) = (Vec::new(), Vec::new());
    let mut split = String::new();
    for path in paths(&args.meshes, args.scans.as_deref())? {
        let folder = tempfile::tempdir()?;
        let name = path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
        eprintln!("{}: building", path.display());
        let paper = build(&paper, &path, &folder.path().join("paper.fct"))?;
        let other = build(&other, &path, &folder.path().join("other.fct"))?;
        other.meta().split.clone_into(&mut split);
        let mesh = format!("{name} ({} faces)", other.face_count());
        measure(&mesh, [&paper, &other], &args.clusters, &mut rows, &mut wrong)?;
    }
    let mut out = std::io::stdout().lock();
    print(&rows, &split, &mut out)?;
    if let Some(machine) = &args.append {
        writeln!(out, "appended to {}", ledger::append(machine, &entries(&rows, &split))?.display())?;
    }
    if wrong.is_empty() { Ok(()) } else { Err(format!("wrong answers:\n  {}", wrong.join("\n  ")).into()) }
}

fn build(builder: &Builder, path: &Path, file: &Path) -> Result<Tree, Box<dyn Error>> {
    builder.run(path, file)?;
    Ok(Tree::open(file)?)
}

/// One mesh; what is wrong with its trees goes to `wrong`.
fn measure(
    mesh: &str,
    trees: [&Tree; 2],
    sizes: &[u32],
    rows: &mut Vec<Row>,
    wrong: &mut Vec<String>,
) -> Result<(), Box<dyn Error>> {
    let mut row = |at: &str, what, [paper, other]: [f64; 2]| {
        rows.push(Row { mesh: mesh.to_owned(), at: at.to_owned(), what, paper, other });
    };
    let faces = trees.map(Tree::faces);
    let [Ok(paper_faces), Ok(other_faces)] = &faces else {
        return Err(format!("{mesh}: the faces of a tree cannot be read").into());
    };
    for &size in sizes.iter().filter(|n| **n as usize <= trees[0].face_count() / 4) {
        eprintln!("{mesh}: {size} clusters");
        let mut culls = [Culls::default(); 2];
        for ((tree, faces), culls) in trees.into_iter().zip([paper_faces, other_faces]).zip(&mut culls) {
            let cut = Cut::of(tree, size as usize)?;
            *culls = cut.culls(tree, faces);
            let found = cut.wrong(tree, faces);
            wrong.extend(
                found.map(|what| format!("{mesh}, split {}, {size} clusters: {what}", tree.meta().split)),
            );
        }
        let at = format!("{size} clusters");
        row(&at, "sphere", culls.map(|c| c.sphere));
        row(&at, "half angle", culls.map(|c| c.half_angle));
        row(&at, "kept", culls.map(|c| c.kept));
        if culls.iter().all(|c| c.overdraw.is_some()) {
            row(&at, "overdraw", culls.map(|c| c.overdraw.unwrap_or(0.0)));
        }
    }
    eprintln!("{mesh}: walking");
    let [paper, other] = trees.map(orbit::visits);
    let visits: [Visits; 2] = [paper?, other?];
    row("path", "nodes visited", visits.map(|v| v.nodes as f64));
    row("path", "triangles", visits.map(|v| v.triangles as f64));
    Ok(())
}

fn print(rows: &[Row], split: &str, out: &mut impl std::io::Write) -> Result<(), Box<dyn Error>> {
    let mut table = Table::new(&["mesh", "at", "what", "paper", split, "ratio", ""]);
    for row in rows {
        let ratio = row.ratio();
        let mark = if ratio > LIMIT { "!" } else { "" };
        table.row(vec![
            row.mesh.clone(),
            row.at.clone(),
            row.what.to_owned(),
            three(row.paper),
            three(row.other),
            format!("{ratio:.2}"),
            mark.to_owned(),
        ]);
    }
    table.print(out)?;
    Ok(())
}

fn entries(rows: &[Row], split: &str) -> Vec<Entry> {
    let entry = |row: &Row| Entry {
        what: format!("culling, {}: paper : {split}", row.what),
        input: row.mesh.clone(),
        setting: row.at.clone(),
        value: format!("{} : {}", three(row.paper), three(row.other)),
        unit: match row.what {
            "half angle" => "degrees",
            "nodes visited" | "triangles" => "count",
            _ => "ratio",
        },
        how: "cargo xtask bench culling".to_owned(),
    };
    rows.iter().map(entry).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_than_the_limit_is_marked() {
        let row =
            |other| Row { mesh: "m".into(), at: "9 clusters".into(), what: "sphere", paper: 2.0, other };
        let mut out = Vec::new();
        print(&[row(2.2), row(2.4)], "quality", &mut out).unwrap();
        let text = String::from_utf8(out).unwrap();
        let marked: Vec<bool> = text.lines().skip(1).map(|line| line.ends_with('!')).collect();
        assert_eq!(marked, [false, true, false], "{text}");
        assert_eq!(row(2.0).ratio(), 1.0);
    }
}

//! `cargo xtask bench quality`: how near coarse meshes are to the surface, beside simplification by quadrics.

use std::error::Error;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use fcextract::Order;
use fct::Tree;

use super::builder::Builder;
use super::distance::{Distance, Reference};
use super::drawn::{Drawn, full, within};
use super::input::{Input, open_edges, paths, same_faces};
use super::ledger;
use super::peers::{ClusterLod, MeshLab, keep_vertices, move_vertices};
use super::scores::{Ours, Peer, Scores};
use super::targets::Size;
use crate::data::ply_out::Mesh;

const EXAMPLES: &str = "\
Examples:
  cargo xtask bench quality                                      the sample meshes
  cargo xtask bench quality --scans ~/stanford                   and bunny, armadillo and dragon
  cargo xtask bench quality --split cca bunny.ply                one mesh, another way to split
  cargo xtask bench quality --sizes 1000,10% --no-meshlab a.ply  the quick part of it
  cargo xtask bench quality --append my-laptop                   keep the figures

RMS and maximum are symmetric surface distances in 1e-4 of the bounding box's diagonal: the RMS
over samples spread evenly over either surface, the maximum over samples and vertices.
A ratio is ours over the peer's at the same number of triangles; ~ marks one that is not judged,
because the peer did not reach the number.

It fails when an answer is wrong: a cut over its number, a crack in a closed mesh, a full
resolution that is not the input. A figure that is only missed is marked.";

/// What `cargo xtask bench quality` is told.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// Meshes [default: the samples in data/, and the scans of --scans]
    #[arg(value_name = "MESH")]
    meshes: Vec<PathBuf>,
    /// Folder with bunny.ply, armadillo.ply and dragon.ply of the Stanford 3D Scanning Repository
    #[arg(long, env = "FCT_DATA", value_name = "DIR")]
    scans: Option<PathBuf>,
    /// How fcbuild splits [default: as fcbuild does by itself]
    #[arg(long, value_name = "MODE")]
    split: Option<String>,
    /// Numbers of triangles, or shares of the faces; those above half of a mesh are left out
    #[arg(long, value_name = "N,..", value_delimiter = ',', default_value = Size::DEFAULT, value_parser = Size::parse)]
    sizes: Vec<Size>,
    /// Samples on either surface
    #[arg(long, value_name = "N", default_value_t = 200_000, value_parser = clap::value_parser!(u32).range(1_000..=10_000_000))]
    samples: u32,
    /// Leave MeshLab out, which takes longest
    #[arg(long)]
    no_meshlab: bool,
    /// A fcbuild to measure [default: that of this workspace, built first]
    #[arg(long, value_name = "PROGRAM")]
    fcbuild: Option<PathBuf>,
    /// Append the figures to docs/benchmarks/MACHINE/DATE.csv
    #[arg(long, value_name = "MACHINE")]
    append: Option<String>,
}

/// Measures and prints.
///
/// # Errors
/// When something cannot be run, or an answer is wrong.
pub(crate) fn run(args: &Args) -> Result<(), Box<dyn Error>> {
    let builder = Builder::new(args.fcbuild.as_deref(), args.split.as_deref())?;
    let meshlab =
        if args.no_meshlab { Err("MeshLab is left out: --no-meshlab".into()) } else { MeshLab::find() };
    if let Err(why) = &meshlab {
        eprintln!("{why}");
    }
    let mut scores = Scores::default();
    let mut wrong = Vec::new();
    for path in paths(&args.meshes, args.scans.as_deref())? {
        measure(&path, args, &builder, meshlab.as_ref().ok(), &mut scores, &mut wrong)?;
    }
    let mut out = std::io::stdout().lock();
    scores.print(&mut out)?;
    if let Some(machine) = &args.append {
        let path = ledger::append(machine, &scores.entries(args.samples))?;
        writeln!(out, "appended to {}", path.display())?;
    }
    if wrong.is_empty() { Ok(()) } else { Err(format!("wrong answers:\n  {}", wrong.join("\n  ")).into()) }
}

/// One mesh; what is wrong with its answers goes to `wrong`.
fn measure(
    path: &Path,
    args: &Args,
    builder: &Builder,
    meshlab: Option<&MeshLab>,
    scores: &mut Scores,
    wrong: &mut Vec<String>,
) -> Result<(), Box<dyn Error>> {
    let folder = tempfile::tempdir()?;
    let file = folder.path().join("tree.fct");
    eprintln!("{}: building", path.display());
    builder.run(path, &file)?;
    let tree = Tree::open(&file)?;
    let input = Input::read(path, tree.meta().origin)?;
    let reference = Reference::new(&input.mesh, args.samples as usize);
    let whole = full(&tree)?.mesh;
    if !same_faces(&whole, &input.mesh) {
        let d = reference.distance(&whole);
        wrong.push(format!("{}: full resolution is not the input; {} {} apart", input.name, d.max, UNIT));
    }
    drop(whole);
    scores.begin(&input, &tree.meta().split);
    let mut judge = Judge { input: &input, reference: &reference, wrong };
    let half = input.mesh.faces.len() as u64 / 2;
    let sizes: Vec<(Size, u64)> = args.sizes.iter().map(|s| (*s, s.of(input.mesh.faces.len()))).collect();
    let mut sizes: Vec<(Size, u64)> = sizes.into_iter().filter(|(_, n)| (4..=half).contains(n)).collect();
    sizes.sort_by_key(|(_, n)| *n);
    let mut budget = Vec::new();
    for (size, n) in &sizes {
        eprintln!("{}: {size} triangles", input.name);
        let ours = judge.ours(within(&tree, *n, Order::Budget)?, *n);
        let kept = judge.peer(&keep_vertices(&input.mesh, ours.triangles));
        let moved = judge.peer(&move_vertices(&input.mesh, ours.triangles));
        budget.push((*size, ours, kept, moved));
        let ours = judge.ours(within(&tree, *n, Order::Bound)?, *n);
        let kept = judge.peer(&keep_vertices(&input.mesh, ours.triangles));
        scores.guaranteed(*size, ours, kept);
    }
    let mut quadrics = Vec::new();
    if let Some(meshlab) = meshlab {
        eprintln!("{}: MeshLab", input.name);
        let counts: Vec<u64> = budget.iter().map(|(_, ours, _, _)| ours.triangles).collect();
        quadrics = meshlab.quadrics(&input.mesh, &counts)?.iter().map(|m| judge.peer(m)).collect();
    }
    for (i, (size, ours, kept, moved)) in budget.into_iter().enumerate() {
        scores.budget(size, ours, kept, moved, quadrics.get(i).copied());
    }
    eprintln!("{}: cluster LOD", input.name);
    let lod = ClusterLod::build(&input.mesh);
    let mut last = 0;
    for (_, n) in &sizes {
        let cut = lod.within(*n, &input.mesh);
        let triangles = cut.faces.len() as u64;
        // One cut may be the finest for several sizes, and the coarsest may be too fine for all of them.
        if triangles == last || triangles > half {
            continue;
        }
        last = triangles;
        let ours = judge.ours(within(&tree, triangles, Order::Budget)?, triangles);
        scores.cluster_lod(ours, judge.peer(&cut));
    }
    Ok(())
}

/// What distances are given in.
pub(crate) const UNIT: &str = "1e-4 of the diagonal";

/// Measures meshes of one input and finds what is wrong with them.
struct Judge<'a> {
    input: &'a Input,
    reference: &'a Reference,
    wrong: &'a mut Vec<String>,
}

impl Judge<'_> {
    fn ours(&mut self, drawn: Drawn, wanted: u64) -> Ours {
        let Drawn { mesh, triangles, exists } = drawn;
        let distance = self.reference.distance(&mesh);
        let name = &self.input.name;
        if triangles > wanted && exists {
            self.wrong.push(format!(
                "{name}: {triangles} triangles where at most {wanted} were asked for and can be had"
            ));
        }
        let open = open_edges(&mesh);
        if self.input.closed && open > 0 {
            self.wrong.push(format!("{name}: {open} unmatched edges in a cut of {triangles} triangles"));
        }
        if !distance.rms.is_finite() {
            self.wrong.push(format!("{name}: a cut of {triangles} triangles has no finite distance"));
        }
        Ours { triangles, distance }
    }

    fn peer(&self, mesh: &Mesh) -> Peer {
        let distance: Distance = self.reference.distance(mesh);
        Peer { triangles: mesh.faces.len() as u64, distance }
    }
}

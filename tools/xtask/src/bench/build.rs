//! `cargo xtask bench build`: what making a tree takes, beside cluster LOD and the Nexus builder.

use std::error::Error;
use std::fs::{self, File};
use std::io::{BufReader, Read, Write as _};
use std::path::{Path, PathBuf};
use std::time::Instant;

use fct::Tree;

use super::builder::Builder;
use super::costs::{Cost, Costs};
use super::input::Input;
use super::ledger;
use super::peers::{MeshLab, build_only};
use super::process::{Run, median, run as run_program};
use super::subdivision::large;
use crate::data::ply_out::write_file;

const EXAMPLES: &str = "\
Examples:
  cargo xtask bench build                          generated meshes of 1 and 4 million faces
  cargo xtask bench build --scans ~/stanford       and the dragon
  cargo xtask bench build --faces 16000000         and 16 million; takes 4 GB of memory
  cargo xtask bench build --check dragon.ply       the same bytes for 1, 2 and 3 threads, too
  cargo xtask bench build --append my-laptop       keep the figures

Times are medians of whole processes, a mesh file in and a synced .fct out; the mesh file is in
the system's cache. Cluster LOD is built from the same mesh in memory by one thread, in turns with
fcbuild; nothing of it is written.

It fails when an answer is wrong: a tree that does not verify or has lost a face, or bytes that
differ between runs. A figure that is only missed is marked.";

/// The generated meshes: each has four times the faces of the one before.
const SMALLEST: u64 = 1_000_000;

/// Above so many faces the Nexus builder takes minutes.
const NEXUS_FACES: usize = 5_000_000;

/// What `cargo xtask bench build` is told.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// Meshes [default: generated ones, and the dragon of --scans]
    #[arg(value_name = "MESH")]
    meshes: Vec<PathBuf>,
    /// Folder with dragon.ply of the Stanford 3D Scanning Repository
    #[arg(long, env = "FCT_DATA", value_name = "DIR")]
    scans: Option<PathBuf>,
    /// Faces of the largest generated mesh; they have 1, 4, 16 million
    #[arg(long, value_name = "N", default_value_t = 4_000_000, value_parser = clap::value_parser!(u64).range(1_000_000..=64_000_000))]
    faces: u64,
    /// How fcbuild splits [default: as fcbuild does by itself]
    #[arg(long, value_name = "MODE")]
    split: Option<String>,
    /// Threads of fcbuild
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..=256))]
    threads: u32,
    /// Runs of which the median counts
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=99))]
    runs: u32,
    /// Compare the bytes for 1, 2 and 3 threads
    #[arg(long)]
    check: bool,
    /// Leave the Nexus builder out, which takes longest
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
        if args.no_meshlab { Err("Nexus is left out: --no-meshlab".into()) } else { MeshLab::find() };
    if let Err(why) = &meshlab {
        eprintln!("{why}");
    }
    // On the disk that holds the sources rather than in the system's temporary folder, which may be memory.
    let home = super::workspace().join("out");
    fs::create_dir_all(&home)?;
    let folder = tempfile::tempdir_in(home)?;
    let bench = Bench { args, builder, meshlab: meshlab.ok(), folder: folder.path() };
    let mut costs = Costs::new(args.threads, args.runs);
    let mut wrong = Vec::new();
    for path in &args.meshes {
        bench.measure(path, &mut costs, &mut wrong)?;
    }
    if args.meshes.is_empty() {
        if let Some(scans) = &args.scans {
            bench.measure(&scans.join("dragon.ply"), &mut costs, &mut wrong)?;
        }
        let mut faces = SMALLEST;
        while faces <= args.faces {
            eprintln!("making a mesh of {faces} faces");
            let (name, mesh) = large(faces)?;
            let path = folder.path().join(format!("{name}.ply"));
            write_file(&path, &mesh, &[], "sculpture, cut finer")?;
            drop(mesh);
            bench.measure(&path, &mut costs, &mut wrong)?;
            fs::remove_file(&path)?;
            faces *= 4;
        }
    }
    let mut out = std::io::stdout().lock();
    costs.print(&mut out)?;
    if let Some(machine) = &args.append {
        writeln!(out, "appended to {}", ledger::append(machine, &costs.entries())?.display())?;
    }
    if wrong.is_empty() { Ok(()) } else { Err(format!("wrong answers:\n  {}", wrong.join("\n  ")).into()) }
}

/// What is the same for all meshes.
struct Bench<'a> {
    args: &'a Args,
    builder: Builder,
    meshlab: Option<MeshLab>,
    folder: &'a Path,
}

impl Bench<'_> {
    fn measure(&self, path: &Path, costs: &mut Costs, wrong: &mut Vec<String>) -> Result<(), Box<dyn Error>> {
        let Input { name, mesh, .. } = Input::read(path, [0.0; 3])?;
        let faces = mesh.faces.len();
        let first = self.folder.join("first.fct");
        let (mut runs, mut lod) = (Vec::new(), Vec::new());
        for turn in 1..=self.args.runs {
            eprintln!("{name}: {faces} faces, run {turn} of {}", self.args.runs);
            runs.push(self.build(path, self.args.threads, &first, &name, wrong)?);
            let start = Instant::now();
            if build_only(&mesh) == 0 {
                wrong.push(format!("{name}: cluster LOD made no group"));
            }
            lod.push(start.elapsed().as_secs_f64());
        }
        if self.args.check {
            for threads in [1, 2, 3] {
                eprintln!("{name}: bytes for {threads} threads");
                self.build(path, threads, &first, &name, wrong)?;
            }
        }
        let tree = Tree::open(&first)?;
        if let Err(error) = tree.verify() {
            wrong.push(format!("{name}: the tree does not verify: {error}"));
        }
        let (kept, dropped) = (tree.meta().faces_kept, tree.meta().dropped.iter().map(|d| d.1).sum::<u64>());
        if kept != faces as u64 || kept + dropped != tree.meta().faces_in {
            wrong.push(format!(
                "{name}: {kept} faces kept and {dropped} dropped of {}; {faces} are left after welding",
                tree.meta().faces_in
            ));
        }
        let split = tree.meta().split.clone();
        let file = fs::metadata(&first)?.len();
        drop(tree);
        drop(mesh);
        fs::remove_file(&first)?;
        let nexus = match &self.meshlab {
            Some(meshlab) if faces <= NEXUS_FACES => {
                eprintln!("{name}: Nexus");
                Some(meshlab.nexus(path, &self.folder.join("nexus.nxs"))?)
            }
            _ => None,
        };
        let of = |what: fn(&Run) -> Option<f64>| median(runs.iter().filter_map(what));
        costs.add(Cost {
            name,
            faces,
            split,
            seconds: of(|r| Some(r.seconds)).unwrap_or(f64::NAN),
            processor: of(|r| r.processor),
            peak: runs.iter().filter_map(|r| r.peak).max(),
            file,
            cluster_lod: median(lod).unwrap_or(f64::NAN),
            nexus,
        });
        Ok(())
    }

    /// One run of fcbuild. Its file becomes `first`, or is compared with it.
    fn build(
        &self,
        path: &Path,
        threads: u32,
        first: &Path,
        name: &str,
        wrong: &mut Vec<String>,
    ) -> Result<Run, Box<dyn Error>> {
        let output = self.folder.join("next.fct");
        let run = run_program(&mut self.builder.command(path, &output, Some(threads)))?;
        if !first.exists() {
            fs::rename(&output, first)?;
        } else {
            if !same_bytes(first, &output)? {
                wrong.push(format!("{name}: two runs differ, the later with {threads} threads"));
            }
            fs::remove_file(&output)?;
        }
        Ok(run)
    }
}

/// Whether two files are the same, read piece by piece.
fn same_bytes(a: &Path, b: &Path) -> Result<bool, Box<dyn Error>> {
    if fs::metadata(a)?.len() != fs::metadata(b)?.len() {
        return Ok(false);
    }
    let open = |path| File::open(path).map(|f| BufReader::with_capacity(1 << 20, f));
    let (mut a, mut b) = (open(a)?, open(b)?);
    let (mut left, mut right) = (vec![0; 1 << 16], vec![0; 1 << 16]);
    loop {
        let count = a.read(&mut left)?;
        if count == 0 {
            return Ok(true);
        }
        b.read_exact(&mut right[..count])?;
        if left[..count] != right[..count] {
            return Ok(false);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_compared_to_the_last_byte() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, bytes: &[u8]| {
            let path = folder.path().join(name);
            fs::write(&path, bytes).unwrap();
            path
        };
        let mut bytes = vec![7; 200_000];
        let (a, b) = (write("a", &bytes), write("b", &bytes));
        bytes[199_999] = 8;
        let (c, d) = (write("c", &bytes), write("d", &bytes[..199_999]));
        assert!(same_bytes(&a, &b).unwrap());
        assert!(!same_bytes(&a, &c).unwrap() && !same_bytes(&a, &d).unwrap());
    }
}

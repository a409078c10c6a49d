//! `cargo xtask bench stream`: what a view reads of a file that is larger than the memory it may have.

use std::error::Error;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::time::Instant;

use std::collections::BTreeSet;

use fcextract::{ChunkCache, Extraction, Order, Part, Piece, Selection, Stats, Streamed, extract};
use fct::{Chunk, ChunkFile, OwnVertices, Tree, VertexRun};
use glam::DVec3;

use super::builder::Builder;
use super::input::paths;
use super::ledger::{self, Entry};
use super::process::median;
use super::speed::bounds;
use super::table::{Table, three};
use super::targets;
use super::view::View;

const EXAMPLES: &str = "\
Examples:
  cargo xtask bench stream                         the sample meshes
  cargo xtask bench stream --scans ~/stanford      and bunny, armadillo and dragon
  cargo xtask bench stream --part 8 dragon.ply     with an eighth of the file in memory
  cargo xtask bench stream --chunk-faces 1024 a.ply  with smaller chunks
  cargo xtask bench stream --append my-laptop      keep the figures

An eye goes around the mesh, near its surface, in small steps and in jumps.
A frame is drawn from the chunks and pages that are in memory, then what was missing is read, as
the background thread does between frames. Counted a frame, in the mean:
  chunks     that the view goes into, and their pages that it goes into
  pages      bytes of the tops of those chunks, of those pages and of vertices that these use of
             others, over the bytes of the pages that hold what is drawn and the nodes above it
  faults     chunks and pages that were missing when the frame was drawn
  reads, MB  of the file, what is read ahead included
  drawn      triangles of the first picture over those of the exact one
  still      chunks and pages that are missing after that, for want of room

It fails when an answer is wrong: more memory than the budget, or a picture with nothing missing
that has other clusters than that of the whole tree. A figure that is only missed is marked.";

/// Frames of each way.
const FRAMES: usize = 120;

/// What `cargo xtask bench stream` is told.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// Meshes [default: the samples in data/, and the scans of --scans]
    #[arg(value_name = "MESH")]
    meshes: Vec<PathBuf>,
    /// Folder with bunny.ply, armadillo.ply and dragon.ply of the Stanford 3D Scanning Repository
    #[arg(long, env = "FCT_DATA", value_name = "DIR")]
    scans: Option<PathBuf>,
    /// The budget: one part in so many of the file
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u64).range(1..=1000))]
    part: u64,
    /// Pixels that the selection allows, of 1280 x 720
    #[arg(long, value_name = "P", default_value_t = 1.0)]
    pixels: f64,
    /// The most faces of a chunk [default: as fcbuild does by itself]
    #[arg(long, value_name = "N")]
    chunk_faces: Option<u32>,
    /// A fcbuild to build with [default: that of this workspace, built first]
    #[arg(long, value_name = "PROGRAM")]
    fcbuild: Option<PathBuf>,
    /// Append the figures to docs/benchmarks/MACHINE/DATE.csv
    #[arg(long, value_name = "MACHINE")]
    append: Option<String>,
}

/// How the eye goes around.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Way {
    Steps,
    Jumps,
}

impl Way {
    const ALL: [Way; 2] = [Way::Steps, Way::Jumps];

    fn name(self) -> &'static str {
        match self {
            Way::Steps => "steps",
            Way::Jumps => "jumps",
        }
    }

    /// The part of the way around at which a frame is.
    fn part(self, frame: usize) -> f64 {
        match self {
            Way::Steps => 0.25 * frame as f64 / FRAMES as f64,
            // Places that are far from each other and do not come back.
            Way::Jumps => (frame as f64 * 0.618_033_988_749_894_9).fract(),
        }
    }
}

/// Sums over the frames of a way.
#[derive(Clone, Debug, Default)]
struct Sums {
    chunks: u64,
    pages: u64,
    needed_bytes: f64,
    page_bytes: f64,
    faults: u64,
    reads: u64,
    bytes_read: u64,
    triangles: u64,
    exact: u64,
    milliseconds: Vec<f64>,
    still_missing: u64,
}

/// Measures and prints.
///
/// # Errors
/// When something cannot be run, or an answer is wrong.
pub(crate) fn run(args: &Args) -> Result<(), Box<dyn Error>> {
    let builder = Builder::new(args.fcbuild.as_deref(), None)?.in_chunks(args.chunk_faces);
    let mut table = Table::new(&[
        "mesh",
        "file MB",
        "budget MB",
        "crown",
        "way",
        "chunks",
        "their pages",
        "MB in view",
        "pages",
        "faults",
        "reads",
        "MB read",
        "drawn",
        "still",
        "ms",
        "",
    ]);
    let (mut entries, mut wrong) = (Vec::new(), Vec::new());
    for path in paths(&args.meshes, args.scans.as_deref())? {
        measure(&path, args, &builder, &mut table, &mut entries, &mut wrong)?;
    }
    let mut out = std::io::stdout().lock();
    writeln!(out, "\na frame, in the mean over {FRAMES} frames\n")?;
    table.print(&mut out)?;
    if let Some(machine) = &args.append {
        writeln!(out, "appended to {}", ledger::append(machine, &entries)?.display())?;
    }
    if wrong.is_empty() { Ok(()) } else { Err(format!("wrong answers:\n  {}", wrong.join("\n  ")).into()) }
}

fn measure(
    path: &Path,
    args: &Args,
    builder: &Builder,
    table: &mut Table,
    entries: &mut Vec<Entry>,
    wrong: &mut Vec<String>,
) -> Result<(), Box<dyn Error>> {
    let part = args.part;
    let folder = tempfile::tempdir()?;
    let file = folder.path().join("tree.fct");
    let name = path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
    eprintln!("{}: building", path.display());
    builder.run(path, &file)?;
    let tree = Tree::open(&file)?;
    let bytes = tree.header().file_len;
    let crown = ChunkFile::open(&file)?.crown().bytes();
    for way in Way::ALL {
        let cache = match ChunkCache::open(&file, bytes / part) {
            Ok(cache) => cache,
            Err(error) => {
                eprintln!("{name}: left out, {error}");
                return Ok(());
            }
        };
        eprintln!("{name}: {}", way.name());
        // Room for everything: what a picture settles on.
        let all = ChunkCache::open(&file, 2 * bytes)?;
        let sums = walk(&tree, [&cache, &all], (way, args.pixels), &name, wrong)?;
        if cache.stats().peak_bytes > bytes / part {
            wrong.push(format!("{name}: {} bytes taken of {}", cache.stats().peak_bytes, bytes / part));
        }
        let frame = |sum: f64| three(sum / FRAMES as f64);
        let mega = |bytes: f64| three(bytes * 1e-6);
        let ratio = sums.needed_bytes / sums.page_bytes.max(1.0);
        let mut missed = Vec::new();
        if ratio > targets::PAGES {
            missed.push(format!("pages > {}", targets::PAGES));
        }
        let share = format!("{:.1} %", 100.0 * crown as f64 / bytes as f64);
        let drawn = format!("{:.1} %", 100.0 * sums.triangles as f64 / sums.exact.max(1) as f64);
        let cells = [
            name.clone(),
            mega(bytes as f64),
            mega((bytes / part) as f64),
            share,
            way.name().to_owned(),
            frame(sums.chunks as f64),
            frame(sums.pages as f64),
            frame(sums.needed_bytes * 1e-6),
            three(ratio),
            frame(sums.faults as f64),
            frame(sums.reads as f64),
            frame(sums.bytes_read as f64 * 1e-6),
            drawn.clone(),
            frame(sums.still_missing as f64),
            three(median(sums.milliseconds.iter().copied()).unwrap_or(f64::NAN)),
            missed.join(", "),
        ];
        entries.push(Entry {
            what: "streaming, chunks in view : faults : MB read a frame : pages read over needed".to_owned(),
            input: format!("{name} ({} faces)", tree.face_count()),
            setting: format!(
                "{}, {} pixels, 1/{part} of {} MB{}",
                way.name(),
                args.pixels,
                mega(bytes as f64),
                args.chunk_faces.map_or_else(String::new, |n| format!(", chunks of {n} faces"))
            ),
            value: format!("{} : {} : {} : {}", cells[5], cells[9], cells[11], cells[8]),
            unit: "count, MB",
            how: format!(
                "cargo xtask bench stream; {FRAMES} frames at {} pixels, {drawn} of the triangles at once, crown {} of the file",
                args.pixels, cells[3]
            ),
        });
        table.row(cells.to_vec());
    }
    Ok(())
}

/// Goes one way and counts.
fn walk(
    tree: &Tree,
    [cache, all]: [&ChunkCache; 2],
    (way, pixels): (Way, f64),
    name: &str,
    wrong: &mut Vec<String>,
) -> Result<Sums, Box<dyn Error>> {
    let page_bytes = bytes_of_pages(tree);
    let sizes = Sizes::of_file(all.file())?;
    let mut sums = Sums::default();
    let (mut mesh, mut whole) = (Streamed::default(), Extraction::default());
    for frame in 0..FRAMES {
        let selection = selection(tree, way.part(frame), pixels);
        let before = cache.stats();
        cache.begin_frame();
        let start = Instant::now();
        cache.extract(&selection, &mut mesh)?;
        sums.milliseconds.push(start.elapsed().as_secs_f64() * 1e3);
        sums.faults += mesh.missing.len() as u64;
        sums.triangles += mesh.stats.triangles;
        cache.settle();
        let after = cache.stats();
        sums.reads += after.reads - before.reads;
        sums.bytes_read += after.bytes_read - before.bytes_read;

        sums.page_bytes += pages_of(tree, &selection)? as f64 * page_bytes;
        let there = cache.resident();

        extract(tree, &selection, &mut whole)?;
        sums.exact += whole.stats.triangles;
        all.extract_now(&selection, &mut mesh)?;
        if mesh.stats.clusters != whole.stats.clusters || !mesh.missing.is_empty() {
            wrong.push(format!(
                "{name}, {} {frame}: {} clusters, {} of the whole tree",
                way.name(),
                mesh.stats.clusters,
                whole.stats.clusters
            ));
        }
        // Nothing is missing there, so that it enters all that the view needs.
        let needed: Vec<Piece> = mesh.entered.iter().map(|wish| wish.piece).collect();
        let chunks = needed.iter().filter(|piece| matches!(piece, Piece::Chunk(_))).count();
        sums.chunks += chunks as u64;
        sums.pages += (needed.len() - chunks) as u64;
        sums.needed_bytes += sizes.of(&needed) as f64;
        sums.still_missing +=
            needed.iter().filter(|piece| there.binary_search(piece).is_err()).count() as u64;
    }
    Ok(sums)
}

/// An eye near the surface, that looks along it.
fn selection(tree: &Tree, part: f64, pixels: f64) -> Selection {
    let [low, high] = bounds(tree);
    let (center, size) = (low.midpoint(high), (high - low).length());
    let (sin, cos) = (std::f64::consts::TAU * part).sin_cos();
    let eye = center + DVec3::new(cos, 0.1, sin) * (0.4 * size);
    let axis = (center + DVec3::new(-sin, 0.0, cos) * (0.15 * size) - eye).normalize_or(DVec3::Z);
    let view = View { eye, axis };
    Selection {
        frustum: Some(view.frustum(size)),
        backface_eye: Some(eye),
        ..Selection::perspective(view.tolerance(pixels), Order::Bound)
    }
}

/// The pages that hold a cluster that is drawn; the nodes above one in its page are there with it.
fn pages_of(tree: &Tree, selection: &Selection) -> Result<u64, Box<dyn Error>> {
    let reader = tree.reader();
    let mut pages = 0;
    Part::whole(tree, selection).divide(
        tree,
        selection,
        &mut Stats::default(),
        |subtree, _| reader.page(subtree).is_some(),
        |part, _| pages += u64::from(reader.page(&part.subtree).is_some()),
    )?;
    Ok(pages)
}

/// The bytes that are read for each part of a file.
#[derive(Default)]
struct Sizes {
    /// Tops of chunks.
    chunks: Vec<u64>,
    /// Pages but for their vertices.
    pages: Vec<u64>,
    /// The vertices of each page.
    runs: Vec<u64>,
    /// The pages whose vertices each page uses.
    owners: Vec<Vec<u32>>,
}

impl Sizes {
    /// Reads all of a file, and counts.
    fn of_file(file: &ChunkFile) -> Result<Sizes, Box<dyn Error>> {
        fn counted<T>(
            file: &ChunkFile,
            read: impl FnOnce() -> Result<T, fct::Error>,
        ) -> Result<(T, u64), fct::Error> {
            let [_, before] = file.reads();
            let it = read()?;
            let [_, after] = file.reads();
            Ok((it, after - before))
        }
        let mut sizes = Sizes::default();
        for number in 0..file.crown().chunk_count() {
            let (chunk, bytes): (Chunk, u64) = counted(file, || file.load(number))?;
            sizes.chunks.push(bytes);
            for page in chunk.pages() {
                let owners = file.runs_of(&chunk, page).ok_or("a page without its vertices")?;
                let runs: Vec<VertexRun> =
                    owners.iter().map(|owner| file.load_run(*owner)).collect::<Result<_, _>>()?;
                let own: Vec<OwnVertices<'_>> = runs.iter().map(VertexRun::own).collect();
                let (_, bytes) = counted(file, || file.load_page(&chunk, page, &own))?;
                sizes.pages.push(bytes);
                let (_, bytes) = counted(file, || file.load_run(page))?;
                sizes.runs.push(bytes);
                sizes.owners.push(owners);
            }
        }
        Ok(sizes)
    }

    /// What is read for some pieces, if nothing is there: vertices that several pages use once.
    fn of(&self, pieces: &[Piece]) -> u64 {
        let at = |sizes: &[u64], index: u32| sizes.get(index as usize).copied().unwrap_or(0);
        let mut bytes = 0;
        let mut runs = BTreeSet::new();
        for piece in pieces {
            match *piece {
                Piece::Chunk(chunk) => bytes += at(&self.chunks, chunk),
                Piece::Page(page) => {
                    bytes += at(&self.pages, page);
                    runs.extend(self.owners.get(page as usize).into_iter().flatten().copied());
                }
            }
        }
        bytes + runs.into_iter().map(|page| at(&self.runs, page)).sum::<u64>()
    }
}

/// Bytes of a page in the sections that chunks are made of, in the mean.
fn bytes_of_pages(tree: &Tree) -> f64 {
    let section = |tag: &str| tree.sections().iter().find(|s| s.tag.to_string() == tag);
    let tags = ["PAGE", "NODE", "FACE", "LOOP", "LINK", "VERT", "NORM", "COLR"];
    let bytes: u64 = tags.iter().filter_map(|tag| section(tag)).map(|s| s.length).sum();
    bytes as f64 / section("PAGE").map_or(1, |s| s.elem_count).max(1) as f64
}

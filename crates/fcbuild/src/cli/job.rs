//! What is done: import and build on threads of their own, while the main thread listens for signals.

use super::bug;
use super::identity::source_id;
use super::inputs::read_all;
use super::memory;
use super::message::notices;
use super::progress::Stage;
use super::settings::Settings;
use fcbuild::error::ErrorKind;
use fcbuild::import::Tally;
use fcbuild::{BuildOptions, Built, Error, Prepared};
use fct::{Interrupt, Progress, Size, Stopped, counted, grouped};
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

/// Room for recursion, which is bounded by the depth of the tree; the systems' defaults differ.
const STACK_BYTES: usize = 16 << 20;

/// A tree that is built and not yet written.
pub(crate) struct Made {
    /// The tree.
    pub(crate) built: Built,
    /// Vertices of the input, before welding.
    pub(crate) vertices_in: u64,
    /// Tells the input and the settings.
    pub(crate) source_id: u128,
    /// Time of the import.
    pub(crate) import: Duration,
    /// Bytes of memory that the job was expected to take.
    pub(crate) estimate: u64,
}

/// How the job ended.
pub(crate) enum Ended {
    /// By itself.
    Alone(Result<Box<Made>, Error>),
    /// By a signal, with this exit code; the job's threads still run and end with the process.
    BySignal(u8),
}

/// Imports and builds in the background and waits for the end, or for a signal.
pub(crate) fn run(settings: &Settings, progress: &Arc<Progress>, interrupt: &Interrupt) -> Ended {
    let thread = thread::Builder::new().name("job".to_owned()).stack_size(STACK_BYTES);
    let done = {
        let (settings, progress) = (settings.clone(), Arc::clone(progress));
        interrupt.wait_for(thread, move || bug::caught(|| make(&settings, &progress)).map(Box::new))
    };
    match done {
        Ok(made) => Ended::Alone(made),
        Err(Stopped::BySignal(exit)) => Ended::BySignal(exit),
        Err(Stopped::NoThread(e)) => Ended::Alone(Err(no_threads(&e))),
        Err(Stopped::Panicked) => {
            Ended::Alone(Err(Error::new(ErrorKind::Internal, bug::CODE, "the job ended without a word")
                .remedy("please report it with the command and the input")))
        }
    }
}

fn make(settings: &Settings, progress: &Progress) -> Result<Made, Error> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(settings.threads)
        .stack_size(STACK_BYTES)
        .thread_name(|i| format!("build {i}"))
        .build()
        .map_err(|e| no_threads(&e))?;
    let start = Instant::now();
    let mut soup = read_all(&settings.inputs, settings.max_memory.as_ref(), progress)?;
    if settings.flip {
        soup.flip();
    }
    if settings.join_groups {
        soup.join_groups();
    }
    let import = start.elapsed();
    check_strict(settings, &soup.tally)?;

    let estimate = memory::estimate_of_soup(&soup, settings.weld, settings.split);
    memory::check(estimate, settings.max_memory.as_ref())?;
    let counts = format!(
        "{} and {} vertices",
        counted(soup.triangles.len() as u64, "face"),
        grouped(soup.positions.len() as u64)
    );
    let vertices_in = soup.positions.len() as u64;
    let source_id = source_id(&soup, settings.split, settings.weld, settings.color_weight);
    let options = BuildOptions {
        split: settings.split,
        weld: settings.weld,
        color_weight: settings.color_weight,
        progress: &|phase, done, total| progress.tell(Stage::Build(phase).into(), done, total),
    };
    let prepared = pool.install(|| Prepared::new(soup, &options)).map_err(|e| blame(settings, e))?;
    // Seams and borders are known now, which cost more than faces.
    let estimate = memory::estimate(&prepared.extent(), settings.split);
    memory::check(estimate, settings.max_memory.as_ref())?;
    progress.note(&format!("{counts}: about {} of memory", Size::of_bytes(estimate)));
    let mut built = pool.install(|| prepared.build(&options)).map_err(|e| blame(settings, e))?;
    warn_of_seams(&mut built);
    check_strict(settings, &built.tally)?;
    check_books(&built)?;
    let mut flags = if settings.flip { " --flip".to_owned() } else { String::new() };
    if settings.join_groups {
        flags.push_str(" --join-groups");
    }
    if settings.color_weight != BuildOptions::default().color_weight {
        flags = format!("{flags} --color-weight {}", settings.color_weight);
    }
    if settings.chunk_faces != fct::CHUNK_FACES {
        built.set_chunk_faces(settings.chunk_faces).map_err(|e| blame(settings, e))?;
        flags = format!("{flags} --chunk-faces {}", settings.chunk_faces);
    }
    built.meta.generator = format!("fcbuild {}{flags}", env!("CARGO_PKG_VERSION"));
    built.meta.source = settings.input_names();
    Ok(Made { built, vertices_in, source_id, import, estimate })
}

/// Edges at which the surface was cut are a repair like any other.
fn warn_of_seams(built: &mut Built) {
    let edges = built.meta.seam_edges;
    let groups = if built.meta.group_names.len() > 1 {
        ", by faces of two groups (which --join-groups makes one surface of),"
    } else {
        ""
    };
    let (were, there) = if edges == 1 { ("edge was", "there") } else { ("edges were", "at each of them") };
    built.tally.warn(
        "seam_edges",
        edges,
        format!(
            "{} {were} shared by more than two faces{groups} or by faces that are wound against each other; \
             the surface is cut {there}",
            grouped(edges)
        ),
    );
}

/// Refuses repairs where the user wants none. What a tree has no place for is none: the surface is as it was.
fn check_strict(settings: &Settings, tally: &Tally) -> Result<(), Error> {
    let mut found = notices(tally);
    found.retain(|notice| notice.of_surface);
    if !settings.strict || found.is_empty() {
        return Ok(());
    }
    let list: Vec<_> =
        found.iter().map(|n| format!("{} ({}, {})", n.name, n.code, grouped(n.count))).collect();
    let error = Error::bad_input("FC213", format!("--strict refuses to repair: {}", list.join(", ")))
        .remedy("mend the mesh, or leave --strict out to accept the repairs");
    Err(blame(settings, error))
}

/// Names the input, where there is only one that can be to blame.
fn blame(settings: &Settings, error: Error) -> Error {
    match settings.inputs.as_slice() {
        [only] => error.in_file(only),
        _ => error,
    }
}

/// Nothing may get lost: what was read is kept or counted as dropped.
fn check_books(built: &Built) -> Result<(), Error> {
    let (tally, kept) = (&built.tally, built.meta.faces_kept);
    if tally.faces_in == kept.saturating_add(tally.dropped.total()) {
        return Ok(());
    }
    Err(Error::new(
        ErrorKind::Internal,
        bug::CODE,
        format!(
            "{} faces were read, {kept} kept and {} dropped, which is no sum",
            tally.faces_in,
            tally.dropped.total()
        ),
    )
    .remedy("please report it with the input"))
}

fn no_threads(e: &dyn std::fmt::Display) -> Error {
    Error::new(ErrorKind::Limit, "FC507", format!("the threads cannot be started: {e}"))
        .remedy("ask for fewer with --threads")
}

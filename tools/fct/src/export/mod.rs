//! `fct export`: a cut of the tree as a mesh file.

mod interrupt;
mod mesh;
mod obj;
mod output;
mod ply;

use crate::error::Error;
use crate::grouped::counted;
use fcextract::{Budget, Extraction, Order, Perspective, Selection, extract, fit};
use fct::Tree;
use glam::DVec3;
use interrupt::Interrupt;
use mesh::Mesh;
use std::fmt;
use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::path::PathBuf;
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::thread;
use std::time::Duration;

/// Fewer calls of the system than with the default, which shows on large meshes.
const BUFFER: usize = 1 << 20;

/// How long a signal may wait to be noticed.
const LISTEN_EVERY: Duration = Duration::from_millis(50);

/// What to export, and where to.
#[derive(Clone, Debug)]
pub(crate) struct Settings {
    /// The tree.
    pub(crate) input: PathBuf,
    /// The mesh.
    pub(crate) output: PathBuf,
    /// Whether an existing output may be replaced.
    pub(crate) force: bool,
    /// The mesh's format.
    pub(crate) format: Format,
    /// How fine the mesh is.
    pub(crate) detail: Detail,
}

/// Formats that can be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Format {
    /// Binary little-endian PLY.
    Ply,
    /// Wavefront OBJ.
    Obj,
}

/// How fine a mesh is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Detail {
    /// The input's faces.
    Full,
    /// Within a distance of the surface.
    Distance(f64),
    /// At most so many triangles.
    Triangles(u64),
    /// At most so many clusters.
    Clusters(u64),
    /// For a picture.
    View(View),
}

/// A point from which errors are small enough, in all directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct View {
    /// The point, in the input's coordinates.
    pub(crate) eye: [f64; 3],
    /// Allowed error per unit of distance from the eye.
    pub(crate) slope: f64,
}

/// What was exported.
#[derive(Debug)]
pub(crate) struct Exported {
    output: PathBuf,
    triangles: u64,
    vertices: u64,
    clusters: u64,
    collapsed: u64,
    bound: f64,
    by_budget: bool,
}

/// Exports; the output is there as a whole or not at all, also when a signal stops the program.
///
/// # Errors
/// Usage when the output is the input or the selection is empty, I/O when the output exists or cannot be written,
/// a limit when not even the coarsest mesh is within the budget, an invalid file when the tree is damaged.
pub(crate) fn run(settings: &Settings) -> Result<Exported, Error> {
    // Before the temporary is made, so that no signal can leave it behind.
    let interrupt = Interrupt::watch();
    let tree = Tree::open(&settings.input)?;
    let pending = output::prepare(&settings.output, &settings.input, settings.force)?;
    let file = pending.file().try_clone().map_err(|source| Error::Write {
        path: settings.output.clone(),
        what: "cannot write the mesh",
        source,
    })?;
    // The main thread keeps the temporary, to remove it when a signal comes; the job's thread ends with the process.
    let (sender, receiver) = sync_channel(1);
    let job = {
        let settings = settings.clone();
        thread::Builder::new().name("export".to_owned()).spawn(move || {
            // Nobody listens any more after a signal.
            let _ = sender.send(write(&tree, &settings, &file));
        })
    };
    job.map_err(Error::Thread)?;
    let exported = loop {
        match receiver.recv_timeout(LISTEN_EVERY) {
            Ok(done) => break done?,
            Err(RecvTimeoutError::Timeout) => {
                if let Some(exit) = interrupt.exit_code() {
                    return Err(Error::Interrupted { exit });
                }
            }
            // The job has panicked and said so.
            Err(RecvTimeoutError::Disconnected) => return Err(Error::Bug),
        }
    };
    // A signal that came too late to be noticed above still finds the output as it was.
    if let Some(exit) = interrupt.exit_code() {
        return Err(Error::Interrupted { exit });
    }
    output::publish(pending)?;
    Ok(exported)
}

/// Selects, and writes the mesh into `file`.
fn write(tree: &Tree, settings: &Settings, file: &File) -> Result<Exported, Error> {
    let mut cut = Extraction::default();
    let selection = select(tree, settings, &mut cut)?;
    let mesh = Mesh::new(tree, &cut, &selection)?;
    if mesh.triangles.is_empty() {
        return Err(Error::Empty);
    }
    let mut out = BufWriter::with_capacity(BUFFER, file);
    let written = match settings.format {
        Format::Ply => ply::write(&mesh, &mut out),
        Format::Obj => obj::write(&mesh, &mut out),
    };
    written.and_then(|()| out.flush()).map_err(|source| Error::Write {
        path: settings.output.clone(),
        what: "cannot write the mesh",
        source,
    })?;
    Ok(Exported {
        output: settings.output.clone(),
        triangles: mesh.triangles.len() as u64,
        vertices: mesh.vertices.len() as u64,
        clusters: cut.stats.clusters,
        collapsed: mesh.collapsed,
        bound: f64::from(cut.stats.bound) + mesh.step,
        by_budget: matches!(settings.detail, Detail::Triangles(_) | Detail::Clusters(_)),
    })
}

/// Leaves the cut that is asked for in `cut`, and says how it is to be drawn.
fn select(tree: &Tree, settings: &Settings, cut: &mut Extraction) -> Result<Selection, Error> {
    let by_tolerance = |selection: Selection, cut: &mut Extraction| {
        extract(tree, &selection, cut)?;
        Ok(selection)
    };
    let (budget, things, asked) = match settings.detail {
        Detail::Triangles(n) => (Budget::Triangles(n), "triangle", n),
        Detail::Clusters(n) => (Budget::Clusters(n), "cluster", n),
        Detail::Full => return by_tolerance(Selection::full(), cut),
        Detail::Distance(distance) => {
            return by_tolerance(Selection::uniform(distance, Order::Bound), cut);
        }
        Detail::View(view) => {
            let eye = DVec3::from(view.eye) - DVec3::from(tree.meta().origin);
            let view = Perspective { eye, axis: DVec3::ZERO, slope: view.slope, corner_cos: 1.0 };
            return by_tolerance(Selection::perspective(view, Order::Bound), cut);
        }
    };
    let count = |cut: &Extraction| match budget {
        Budget::Triangles(_) => cut.stats.triangles,
        Budget::Clusters(_) => cut.stats.clusters,
    };
    let (selection, fitted) = fit(tree, Selection::by_budget(), budget, cut)?;
    if fitted.within {
        return Ok(selection);
    }
    // The other order keeps other vertices, and its coarsest mesh may be smaller.
    let by_budget = count(cut);
    let coarsest = by_tolerance(Selection::uniform(f64::INFINITY, Order::Bound), cut)?;
    if count(cut) <= asked {
        return Ok(coarsest);
    }
    let found = by_budget.min(count(cut));
    Err(Error::Budget { path: settings.input.clone(), things, asked, found })
}

impl fmt::Display for Exported {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "wrote {}: {}, {}, {}; no point of the surface is farther off than {}",
            self.output.display(),
            counted(self.triangles, "triangle", "triangles"),
            counted(self.vertices, "vertex", "vertices"),
            counted(self.clusters, "cluster", "clusters"),
            self.bound as f32
        )?;
        if self.by_budget {
            // The largest bound among the clusters says little about a mesh that was not chosen by it.
            f.write_str(", a loose bound, since a budget does not go by it (--error does)")?;
        }
        if self.collapsed > 0 {
            let what = counted(self.collapsed, "triangle", "triangles");
            write!(f, "; {what} without area left out")?;
        }
        Ok(())
    }
}

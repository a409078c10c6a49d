//! `fct export`: a cut of the tree as a mesh file.

mod detail;
mod glb;
mod mesh;
mod obj;
mod output;
mod ply;

use crate::SCHEMA;
use crate::counted::counted;
use crate::error::Error;
use crate::stage::Stage;
pub(crate) use detail::{Ball, Detail, Scale};
use fcextract::{Budget, Extraction, Selection};
use fcmeasure::{Distance, Reference};
use fct::grouped;
use fct::{Interrupt, Progress, Tree};
use mesh::Mesh;
use serde_json::json;
use std::fmt;
use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread;

/// Fewer calls of the system than with the default, which shows on large meshes.
const BUFFER: usize = 1 << 20;

/// Points of either surface whose distances from the other are measured: the mean of figures of other samples varies by a
/// hundredth.
const SAMPLES: usize = 100_000;

/// Vertices and triangles between two words of how far the writing is.
const TOLD_EVERY: u64 = 1 << 12;

/// What to export, and where to.
#[derive(Clone, Debug)]
pub(crate) struct Settings {
    /// The tree.
    pub(crate) input: PathBuf,
    /// The meshes: one for each budget, or a single one.
    pub(crate) outputs: Vec<Output>,
    /// Whether an existing output may be replaced.
    pub(crate) force: bool,
    /// The meshes' format.
    pub(crate) format: Format,
    /// How fine they are.
    pub(crate) detail: Detail,
    /// Where they are finer or coarser than that.
    pub(crate) regions: Vec<Ball>,
    /// Whether vertices are drawn at their places in the input.
    pub(crate) in_place: bool,
    /// Whether distances are measured too.
    pub(crate) measure: bool,
}

/// One mesh file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Output {
    /// Where it goes.
    pub(crate) path: PathBuf,
    /// What it has to keep within, if that was asked for.
    pub(crate) budget: Option<Budget>,
}

/// Formats that can be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Format {
    /// Binary little-endian PLY.
    Ply,
    /// Wavefront OBJ.
    Obj,
    /// Binary glTF.
    Glb,
}

/// What was exported, and what the user should know.
#[derive(Debug)]
pub(crate) struct Done {
    /// The meshes.
    pub(crate) meshes: Vec<Exported>,
    /// That an error is large beside the model.
    pub(crate) large_error: Option<String>,
    /// That a region has nothing of the model in it.
    pub(crate) empty_region: Option<String>,
}

/// A mesh that was written.
#[derive(Debug)]
pub(crate) struct Exported {
    output: PathBuf,
    /// The number asked for, if one was.
    asked: Option<u64>,
    /// The number that the next split would take, where the one asked for is missed by far.
    next: Option<u64>,
    triangles: u64,
    vertices: u64,
    clusters: u64,
    collapsed: u64,
    bound: f64,
    measured: Option<Distance>,
    chosen_by: ChosenBy,
    /// Whether the tree has colours, which count in its bounds.
    is_painted: bool,
}

/// What the clusters were held against.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ChosenBy {
    Bound,
    Epsilon,
    Budget,
}

/// Exports, and says what the user should know; the outputs are there as a whole or not at all, also when a signal stops
/// the program.
///
/// # Errors
/// Usage when an output is the input or a selection is empty, I/O when one exists or cannot be written, a limit when not
/// even the coarsest mesh is within a budget, an invalid file when the tree is damaged.
pub(crate) fn run(
    settings: &Settings,
    interrupt: &Interrupt,
    progress: &Arc<Progress>,
) -> Result<Done, Error> {
    let tree = Tree::open(&settings.input)?;
    let large_error = detail::large_error(&tree, &settings.detail);
    let (mut pending, mut files) = (Vec::new(), Vec::new());
    for output in &settings.outputs {
        let prepared = output::prepare(&output.path, &settings.input, settings.force)?;
        files.push(prepared.file().try_clone().map_err(unwritable(&output.path))?);
        pending.push(prepared);
    }
    // The main thread keeps the temporaries, to remove them when a signal comes; the job's thread ends with the process.
    let (job, progress) = (settings.clone(), Arc::clone(progress));
    let (meshes, empty_region) =
        interrupt.wait_for(thread::Builder::new().name("export".to_owned()), move || {
            progress.tell(Stage::Bytes.into(), 0, 1);
            // A mesh outlives its tree, and its bound is a promise: neither may come from damaged bytes.
            tree.check_bytes()?;
            let reference = job.measure.then(|| full_resolution(&tree, &progress)).transpose()?;
            let outputs = job.outputs.iter().zip(&files);
            let meshes = outputs
                .map(|(output, file)| write(&tree, &job, (output, file), reference.as_ref(), &progress));
            Ok::<_, Error>((
                meshes.collect::<Result<Vec<_>, _>>()?,
                detail::empty_region(&tree, &job.regions)?,
            ))
        })??;
    pending.into_iter().try_for_each(output::publish)?;
    Ok(Done { meshes, large_error, empty_region })
}

fn unwritable(path: &Path) -> impl FnOnce(std::io::Error) -> Error {
    let path = path.to_owned();
    move |source| Error::Write { path, what: "cannot write the mesh", source }
}

/// What meshes are measured against: every face of the tree.
fn full_resolution(tree: &Tree, progress: &Progress) -> Result<Reference, Error> {
    progress.tell(Stage::Measure.into(), 0, 1);
    let (mut cut, selection) = (Extraction::default(), Selection::full());
    fcextract::extract(tree, &selection, &mut cut)?;
    Ok(Reference::new(Mesh::new(tree, &cut, &selection)?.surface(), SAMPLES))
}

/// Selects, and writes the mesh into `file`.
fn write(
    tree: &Tree,
    settings: &Settings,
    (output, file): (&Output, &File),
    reference: Option<&Reference>,
    progress: &Progress,
) -> Result<Exported, Error> {
    progress.tell(Stage::Cut.into(), 0, 1);
    let mut cut = Extraction::default();
    let (mut selection, next) = match (&settings.detail, output.budget) {
        (Detail::Budgets(_, eye), Some(budget)) => {
            detail::select_within(tree, budget, *eye, &settings.input, &mut cut)?
        }
        (detail, _) => (detail::select(tree, detail, &settings.regions, &mut cut)?, None),
    };
    selection.displaced &= !settings.in_place;
    progress.tell(Stage::Mesh.into(), 0, 1);
    let mesh = Mesh::new(tree, &cut, &selection)?;
    if mesh.triangles().is_empty() {
        return Err(Error::Empty);
    }
    progress.tell(Stage::Bound.into(), 0, 1);
    let bound = selection.bound_of(tree, &cut.stats, &mesh.buffers)?;
    let measured = reference.map(|reference| {
        progress.tell(Stage::Measure.into(), 0, 1);
        reference.distance(mesh.surface())
    });
    let mut out = BufWriter::with_capacity(BUFFER, file);
    let (mut done, total) = (0_u64, (mesh.buffers.positions.len() + mesh.triangles().len()) as u64);
    let mut step = || {
        if done % TOLD_EVERY == 0 {
            progress.tell(Stage::Write.into(), done, total);
        }
        done += 1;
    };
    let written = match settings.format {
        Format::Ply => ply::write(&mesh, &mut out, &mut step),
        Format::Obj => obj::write(&mesh, &mut out, &mut step),
        Format::Glb => glb::write(&mesh, &mut out, &mut step),
    };
    written.and_then(|()| out.flush()).map_err(unwritable(&output.path))?;
    Ok(Exported {
        output: output.path.clone(),
        asked: output.budget.map(|(Budget::Triangles(n) | Budget::Clusters(n))| n),
        next,
        triangles: mesh.triangles().len() as u64,
        vertices: mesh.buffers.positions.len() as u64,
        clusters: cut.stats.clusters,
        collapsed: mesh.buffers.collapsed,
        bound,
        measured,
        chosen_by: match settings.detail {
            Detail::Full | Detail::Within(_) => ChosenBy::Bound,
            Detail::Epsilon(_) => ChosenBy::Epsilon,
            Detail::Budgets(..) => ChosenBy::Budget,
        },
        is_painted: tree.colors().is_some(),
    })
}

/// For programs.
pub(crate) fn to_json(tree: &Path, done: &[Exported]) -> String {
    let meshes: Vec<_> = done
        .iter()
        .map(|mesh| {
            json!({
                "path": mesh.output.to_string_lossy(),
                "asked": mesh.asked,
                "next": mesh.next,
                "triangles": mesh.triangles,
                "vertices": mesh.vertices,
                "clusters": mesh.clusters,
                "collapsed": mesh.collapsed,
                "bound": mesh.bound,
                "measured": mesh.measured.map(|distance| {
                    json!({ "rms": distance.rms, "max": distance.max, "color_rms": distance.color_rms, "samples": 2 * SAMPLES })
                }),
                "chosen_by": match mesh.chosen_by {
                    ChosenBy::Bound => "bound",
                    ChosenBy::Epsilon => "epsilon",
                    ChosenBy::Budget => "budget",
                },
            })
        })
        .collect();
    format!("{:#}", json!({ "schema": SCHEMA, "input": tree.to_string_lossy(), "meshes": meshes }))
}

impl Exported {
    /// What to tell a user whose budget is missed by far.
    pub(crate) fn missed(&self) -> Option<String> {
        let (asked, next) = (self.asked?, self.next?);
        Some(format!(
            "{} ends far below the {} asked for, since no split fits that is left: the smallest takes about {}; a \
             tree of --split quality has smaller steps",
            self.output.display(),
            grouped(asked),
            grouped(next)
        ))
    }
}

impl fmt::Display for Exported {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "wrote {}: {}, {}, {}; surface and mesh are no farther apart than {}",
            self.output.display(),
            counted(self.triangles, "triangle", "triangles"),
            counted(self.vertices, "vertex", "vertices"),
            counted(self.clusters, "cluster", "clusters"),
            self.bound as f32
        )?;
        // The largest bound among the clusters says little about a mesh that was not chosen by it.
        f.write_str(match self.chosen_by {
            // Nothing is below zero.
            _ if self.bound == 0.0 => "",
            ChosenBy::Bound => "",
            ChosenBy::Epsilon => ", a loose bound, since a mean error does not go by it (--error does)",
            ChosenBy::Budget if self.is_painted => {
                ", a loose bound, since a budget does not go by it (--error does) and colours count in it (--measure tells)"
            }
            ChosenBy::Budget => ", a loose bound, since a budget does not go by it (--error does)",
        })?;
        if let Some(Distance { rms, max, color_rms }) = self.measured {
            write!(
                f,
                "; measured: {} in the mean (root mean square), {} at the most",
                rms as f32, max as f32
            )?;
            if let Some(color_rms) = color_rms {
                write!(f, "; colours {:.1} % apart in the mean (root mean square)", 100.0 * color_rms)?;
            }
        }
        if self.collapsed > 0 {
            let what = counted(self.collapsed, "triangle", "triangles");
            write!(f, "; {what} without area left out")?;
        }
        Ok(())
    }
}

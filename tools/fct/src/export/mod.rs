//! `fct export`: a cut of the tree as a mesh file.

mod mesh;
mod obj;
mod output;
mod ply;

use crate::error::Error;
use crate::grouped::grouped;
use fcextract::{Budget, Extraction, Order, Perspective, Selection, extract, fit};
use fct::Tree;
use glam::DVec3;
use mesh::Mesh;
use output::PendingFile;
use std::fmt;
use std::io::Write as _;
use std::path::PathBuf;

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
    bound: f32,
}

/// Exports; the output is there as a whole or not at all.
///
/// # Errors
/// Usage when the output is the input or the selection is empty, I/O when the output exists or cannot be written,
/// a limit when not even the coarsest mesh is within the budget, an invalid file when the tree is damaged.
pub(crate) fn run(settings: &Settings) -> Result<Exported, Error> {
    let tree = Tree::open(&settings.input)?;
    let mut pending = PendingFile::create(&settings.output, &settings.input, settings.force)?;
    let mut cut = Extraction::default();
    select(&tree, settings, &mut cut)?;
    let mesh = Mesh::new(&tree, &cut)?;
    if mesh.triangles.is_empty() {
        return Err(Error::Empty);
    }
    let mut out = pending.writer();
    let written = match settings.format {
        Format::Ply => ply::write(&mesh, &mut out),
        Format::Obj => obj::write(&mesh, &mut out),
    };
    let flushed = written.and_then(|()| out.flush());
    drop(out);
    pending.finish(flushed)?;
    Ok(Exported {
        output: settings.output.clone(),
        triangles: mesh.triangles.len() as u64,
        vertices: mesh.vertices.len() as u64,
        clusters: cut.stats.clusters,
        collapsed: mesh.collapsed,
        bound: cut.stats.bound,
    })
}

fn select(tree: &Tree, settings: &Settings, cut: &mut Extraction) -> Result<(), Error> {
    let (budget, things, asked) = match settings.detail {
        Detail::Triangles(n) => (Budget::Triangles(n), "triangles", n),
        Detail::Clusters(n) => (Budget::Clusters(n), "clusters", n),
        Detail::Full => return Ok(extract(tree, &Selection::full(), cut)?),
        Detail::Distance(distance) => {
            return Ok(extract(tree, &Selection::uniform(distance, Order::Bound), cut)?);
        }
        Detail::View(view) => {
            let eye = DVec3::from(view.eye) - DVec3::from(tree.meta().origin);
            let view = Perspective { eye, axis: DVec3::ZERO, slope: view.slope, corner_cos: 1.0 };
            return Ok(extract(tree, &Selection::perspective(view, Order::Bound), cut)?);
        }
    };
    if fit(tree, budget, cut)?.within {
        return Ok(());
    }
    let found = match budget {
        Budget::Triangles(_) => cut.stats.triangles,
        Budget::Clusters(_) => cut.stats.clusters,
    };
    Err(Error::Budget { path: settings.input.clone(), things, asked, found })
}

impl fmt::Display for Exported {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "wrote {}: {} triangles, {} vertices, {} clusters; no point of the surface is farther off than {}",
            self.output.display(),
            grouped(self.triangles),
            grouped(self.vertices),
            grouped(self.clusters),
            self.bound
        )?;
        if self.collapsed > 0 {
            write!(f, "; {} triangles without area left out", grouped(self.collapsed))?;
        }
        Ok(())
    }
}

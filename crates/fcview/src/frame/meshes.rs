//! The triangles of pieces, cut in parallel.

use super::corners::{self, Paint};
use super::pieces::Piece;
use super::plan::Plan;
use crate::Error;
use crate::gpu::pipelines::ClusterVertex;
use crate::scene::Scene;
use fcextract::{Extraction, Stats};
use rayon::prelude::*;

/// Runs of pieces that are cut together and lie together on the GPU; kept for their memory.
#[derive(Default)]
pub(crate) struct Meshes {
    runs: Vec<Mesh>,
    used: usize,
}

/// The triangles of a run of pieces of one instance.
#[derive(Default)]
pub(crate) struct Mesh {
    /// Number of the placed instance.
    pub(crate) placed: u32,
    /// Its model.
    pub(crate) model: usize,
    pub(crate) extraction: Extraction,
    /// The triangles unindexed, where they are painted.
    pub(crate) corners: Vec<ClusterVertex>,
}

/// A run is ended at about this many triangles: enough for a thread to be worth it, few enough to share the work.
const RUN_TRIANGLES: f64 = 2000.0;

impl Meshes {
    /// Cuts pieces, which stand in the order in which they are drawn, and counts.
    ///
    /// # Errors
    /// [`Error::Extract`] if a tree is damaged.
    pub(crate) fn cut(
        &mut self,
        scene: &Scene,
        plan: &Plan,
        pieces: &[Piece],
        paint: Option<Paint>,
        stats: &mut Stats,
    ) -> Result<&[Mesh], Error> {
        let runs = runs(pieces);
        self.used = runs.len();
        if self.runs.len() < runs.len() {
            self.runs.resize_with(runs.len(), Mesh::default);
        }
        let meshes = self.runs.get_mut(..runs.len()).unwrap_or_default();
        meshes
            .par_iter_mut()
            .zip(runs.par_iter())
            .try_for_each(|(mesh, run)| mesh.fill(scene, plan, run, paint))?;
        for mesh in meshes.iter() {
            let one = &mesh.extraction.stats;
            stats.nodes_visited += one.nodes_visited;
            stats.culled_frustum += one.culled_frustum;
            stats.culled_cone += one.culled_cone;
            stats.faces_culled += one.faces_culled;
            stats.clusters += one.clusters;
            stats.folded += one.folded;
            stats.triangles += one.triangles;
        }
        Ok(meshes)
    }
}

impl Mesh {
    fn fill(
        &mut self,
        scene: &Scene,
        plan: &Plan,
        pieces: &[Piece],
        paint: Option<Paint>,
    ) -> Result<(), Error> {
        self.extraction.clear();
        self.corners.clear();
        let Some(first) = pieces.first() else { return Ok(()) };
        let Some(placed) = plan.placed.get(first.placed as usize) else { return Ok(()) };
        (self.placed, self.model) = (first.placed, placed.model);
        let Some(model) = scene.models.get(placed.model) else { return Ok(()) };
        let failed = |source| Error::Extract { model: model.name.clone(), source };
        for piece in pieces {
            self.extraction.append(&model.tree, &placed.selection, &piece.part).map_err(failed)?;
        }
        if let Some(paint) = paint {
            let parts = pieces.iter().map(|piece| &piece.part);
            corners::fill(&model.tree, &placed.selection, parts, &self.extraction, paint, &mut self.corners)
                .map_err(failed)?;
        }
        Ok(())
    }
}

/// Consecutive pieces of one instance, in runs of about [`RUN_TRIANGLES`].
fn runs(pieces: &[Piece]) -> Vec<&[Piece]> {
    let mut runs = Vec::new();
    for same in pieces.chunk_by(|a, b| a.placed == b.placed) {
        let mut rest = same;
        while !rest.is_empty() {
            let mut triangles = 0.0;
            let few = |piece: &&Piece| {
                let room = triangles < RUN_TRIANGLES;
                triangles += piece.triangles;
                room
            };
            let count = rest.iter().take_while(few).count();
            let (run, left) = rest.split_at_checked(count).unwrap_or((rest, &[]));
            runs.push(run);
            rest = left;
        }
    }
    runs
}

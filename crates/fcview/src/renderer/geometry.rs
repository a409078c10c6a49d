//! From pieces to runs of triangles on the GPU.

use super::{Frame, Renderer, Run, lap};
use crate::Error;
use crate::frame::pieces::Piece;
use crate::gpu::pages::Place;
use crate::options::Detail;
use crate::stats::FrameStats;
use std::time::Instant;

impl Frame<'_> {
    /// Whether every piece draws all its faces as they stand in the file: then they are cut once for all frames.
    pub(super) fn draws_whole_models(&self) -> bool {
        let options = self.options;
        let culls = options.frustum || (options.backface && !options.two_sided);
        options.detail == Detail::Full && !culls && self.paint.is_none()
    }
}

impl Renderer {
    /// Forgets the last frame's triangles, but not the memory for as many.
    pub(super) fn begin_geometry(&mut self) {
        let used = self.indices.used();
        self.indices.restart(&self.gpu, used);
        let used = self.corners.used();
        self.corners.restart(&self.gpu, used);
    }

    /// Cuts pieces and hands their triangles to the GPU.
    pub(super) fn geometry(
        &mut self,
        frame: &Frame<'_>,
        pieces: &[Piece],
        clock: &mut Instant,
        stats: &mut FrameStats,
    ) -> Result<Vec<Run>, Error> {
        if frame.draws_whole_models() {
            return self.whole_models(frame, pieces, stats);
        }
        let mut cut = fcextract::Stats::default();
        let meshes = self.cuts.cut(frame.scene, frame.plan, pieces, frame.paint, &mut cut)?;
        stats.counts.add(&cut);
        for mesh in meshes {
            let placed = frame.plan.placed.get(mesh.placed as usize);
            let scale =
                placed.and_then(|placed| frame.scene.instances.get(placed.instance)).map_or(1.0, |i| i.scale);
            stats.bound = stats.bound.max(scale * f64::from(mesh.extraction.stats.bound));
        }
        stats.milliseconds.cut += lap(clock);
        let data: Vec<&[u8]> = match frame.paint {
            Some(_) => meshes.iter().map(|mesh| bytemuck::cast_slice(&mesh.corners)).collect(),
            None => meshes.iter().map(|mesh| bytemuck::cast_slice(&mesh.extraction.indices)).collect(),
        };
        let pages = if frame.paint.is_some() { &mut self.corners } else { &mut self.indices };
        let mut place = pages.push(&self.gpu, "the frame", &data)?;
        let mut runs = Vec::with_capacity(meshes.len());
        for mesh in meshes {
            // The format's limit on faces keeps a mesh's indices countable.
            let count = u32::try_from(mesh.extraction.indices.len()).unwrap_or(u32::MAX);
            runs.push(Run { placed: mesh.placed, model: mesh.model, place, count });
            place.first = place.first.saturating_add(count);
        }
        self.finish_stage(frame.options, "the upload")?;
        stats.milliseconds.upload += lap(clock);
        Ok(runs)
    }

    /// Runs of the models' own faces, which are uploaded when they are first asked for.
    fn whole_models(
        &mut self,
        frame: &Frame<'_>,
        pieces: &[Piece],
        stats: &mut FrameStats,
    ) -> Result<Vec<Run>, Error> {
        self.whole.resize(frame.scene.models.len(), None);
        let mut runs = Vec::with_capacity(pieces.len());
        for piece in pieces {
            let Some(placed) = frame.plan.placed.get(piece.placed as usize) else { continue };
            let Some(place) = self.whole_model(frame, placed.model)? else { continue };
            let subtree = &piece.part.subtree;
            let first = place.first.saturating_add(3 * subtree.first_face);
            let count = 3 * subtree.face_count();
            stats.counts.clusters += u64::from(subtree.face_count());
            runs.push(Run {
                placed: piece.placed,
                model: placed.model,
                place: Place { first, ..place },
                count,
            });
        }
        Ok(runs)
    }

    /// Where all faces of a model lie.
    fn whole_model(&mut self, frame: &Frame<'_>, model: usize) -> Result<Option<Place>, Error> {
        if let Some(Some(place)) = self.whole.get(model) {
            return Ok(Some(*place));
        }
        let Some(of_scene) = frame.scene.models.get(model) else { return Ok(None) };
        let faces = of_scene.tree.faces().map_err(|source| Error::Extract {
            model: of_scene.name.clone(),
            source: fcextract::Error::Tree(source),
        })?;
        let place = self.whole_indices.push(&self.gpu, &of_scene.name, &[bytemuck::cast_slice(&faces)])?;
        if let Some(slot) = self.whole.get_mut(model) {
            *slot = Some(place);
        }
        Ok(Some(place))
    }
}

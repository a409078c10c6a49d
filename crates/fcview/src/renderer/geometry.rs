//! From pieces to runs of triangles on the GPU.

use super::passes::Ends;
use super::{Frame, Renderer, Run, lap};
use crate::Error;
use crate::frame::meshes::{Mesh, Meshes};
use crate::frame::pieces::Piece;
use crate::gpu::pages::Place;
use crate::options::Detail;
use crate::residency::Residency;
use crate::stats::FrameStats;
use rayon::prelude::*;
use std::time::Instant;

/// So many pieces are cut and drawn at a time: each has buffers of its own, and there may be a million instances.
const MOST_PIECES: usize = 4096;

impl Renderer {
    /// Whether every piece draws all its faces as they stand in the file: then they are cut once for all frames.
    pub(super) fn draws_whole_models(&self, frame: &Frame<'_>) -> bool {
        let options = frame.options;
        let culls = options.frustum || (options.backface && !options.two_sided);
        let whole = matches!(self.residency, Residency::Whole(_));
        whole && options.detail == Detail::Full && !culls && frame.paint.is_none()
    }

    /// Forgets the last frame's triangles, but not the memory for as many.
    pub(super) fn begin_geometry(&mut self) {
        let used = self.indices.used();
        self.indices.restart(&self.gpu, used);
        let used = self.corners.used();
        self.corners.restart(&self.gpu, used);
    }

    /// Cuts pieces, hands their triangles to the GPU and draws them, with what is before the first ones and after the
    /// last ones of a frame.
    pub(super) fn draw_pieces(
        &mut self,
        frame: &Frame<'_>,
        pieces: &[Piece],
        ends: Ends,
        clock: &mut Instant,
        stats: &mut FrameStats,
    ) -> Result<(), Error> {
        if self.draws_whole_models(frame) {
            let runs = self.whole_models(frame, pieces, stats)?;
            stats.counts.triangles_drawn += self.draw_runs(frame, &runs, ends)?;
            return Ok(());
        }
        // Out of the way, so that the rest can be used beside them.
        let mut cuts = std::mem::take(&mut self.cuts);
        let last = pieces.len().div_ceil(MOST_PIECES).max(1) - 1;
        let drawn = (0..=last).try_for_each(|number| {
            let first = number * MOST_PIECES;
            let some = pieces.get(first..pieces.len().min(first + MOST_PIECES)).unwrap_or(&[]);
            let ends = Ends { first: ends.first && number == 0, last: ends.last && number == last };
            self.draw_cuts(&mut cuts, frame, some, ends, clock, stats)
        });
        self.cuts = cuts;
        drawn
    }

    fn draw_cuts(
        &mut self,
        cuts: &mut Meshes,
        frame: &Frame<'_>,
        pieces: &[Piece],
        ends: Ends,
        clock: &mut Instant,
        stats: &mut FrameStats,
    ) -> Result<(), Error> {
        let mut cut = fcextract::Stats::default();
        let meshes = cuts.cut(frame.scene, frame.plan, pieces, frame.paint, &mut cut)?;
        stats.counts.add(&cut);
        for mesh in meshes {
            let placed = frame.plan.placed.get(mesh.placed as usize);
            let scale =
                placed.and_then(|placed| frame.scene.instances.get(placed.instance)).map_or(1.0, |i| i.scale);
            stats.bound = stats.bound.max(scale * f64::from(mesh.extraction.stats.bound));
        }
        stats.milliseconds.cut += lap(clock);
        if frame.paint.is_none() && matches!(self.residency, Residency::Paged(_)) {
            return self.draw_paged(frame, meshes, ends, clock, stats);
        }
        let data: Vec<&[u8]> = match frame.paint {
            Some(_) => meshes.iter().map(|mesh| bytemuck::cast_slice(&mesh.corners)).collect(),
            None => meshes.iter().map(|mesh| bytemuck::cast_slice(&mesh.extraction.indices)).collect(),
        };
        let pages = if frame.paint.is_some() { &mut self.corners } else { &mut self.indices };
        let place = pages.push(&self.gpu, "the frame", &data)?;
        let counts = meshes.iter().map(|mesh| (mesh, mesh.extraction.indices.len()));
        self.draw_pushed(frame, counts, place, ends, clock, stats)
    }

    /// Draws meshes whose vertices come and go: group by group, each of which has room for its pages.
    fn draw_paged(
        &mut self,
        frame: &Frame<'_>,
        meshes: &[Mesh],
        ends: Ends,
        clock: &mut Instant,
        stats: &mut FrameStats,
    ) -> Result<(), Error> {
        let Residency::Paged(paged) = &self.residency else { return Ok(()) };
        let corners: Vec<(usize, &[u32])> =
            meshes.iter().map(|mesh| (mesh.model, mesh.extraction.indices.as_slice())).collect();
        let (parcels, groups) = paged.parcels(&corners);
        let last = groups.len().saturating_sub(1);
        for (number, group) in groups.into_iter().enumerate() {
            let Residency::Paged(paged) = &mut self.residency else { return Ok(()) };
            let parcels = parcels.get(group).unwrap_or(&[]);
            paged.load(&self.gpu, frame.scene, parcels)?;
            let indices: Vec<Vec<u32>> = parcels
                .par_iter()
                .map(|parcel| {
                    let (model, corners) = corners.get(parcel.mesh).copied().unwrap_or_default();
                    paged.indices(model, corners.get(parcel.corners.clone()).unwrap_or(&[]))
                })
                .collect();
            let data: Vec<&[u8]> = indices.iter().map(|indices| bytemuck::cast_slice(indices)).collect();
            let place = self.indices.push(&self.gpu, "the frame", &data)?;
            let counts = parcels
                .iter()
                .zip(&indices)
                .filter_map(|(parcel, indices)| Some((meshes.get(parcel.mesh)?, indices.len())));
            let ends = Ends { first: ends.first && number == 0, last: ends.last && number == last };
            self.draw_pushed(frame, counts, place, ends, clock, stats)?;
        }
        Ok(())
    }

    /// Draws meshes, of each so many corners, that lie one after the other from a place on.
    fn draw_pushed<'a>(
        &mut self,
        frame: &Frame<'_>,
        meshes: impl Iterator<Item = (&'a Mesh, usize)>,
        mut place: Place,
        ends: Ends,
        clock: &mut Instant,
        stats: &mut FrameStats,
    ) -> Result<(), Error> {
        let mut runs = Vec::new();
        for (mesh, count) in meshes {
            // The format's limit on faces keeps a mesh's indices countable.
            let count = u32::try_from(count).unwrap_or(u32::MAX);
            runs.push(Run { placed: mesh.placed, model: mesh.model, place, count });
            place.first = place.first.saturating_add(count);
        }
        self.finish_stage(frame.options, "the upload")?;
        stats.milliseconds.upload += lap(clock);
        stats.counts.triangles_drawn += self.draw_runs(frame, &runs, ends)?;
        Ok(())
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

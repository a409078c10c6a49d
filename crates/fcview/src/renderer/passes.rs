//! Drawing runs of triangles.

use super::{Frame, Renderer, Run};
use crate::Error;
use crate::gpu::pipelines::Look;

/// What is set in a pass: look, model, and page of the triangles.
type State = Option<(Look, usize, usize)>;

/// Which of a frame's passes one is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ends {
    /// It begins the picture.
    pub(super) first: bool,
    /// It completes the picture.
    pub(super) last: bool,
}

impl Renderer {
    /// Draws runs in their order. Returns the number of triangles drawn.
    pub(super) fn draw_runs(&self, frame: &Frame<'_>, runs: &[Run], ends: Ends) -> Result<u64, Error> {
        let (Some(pipelines), Some(target)) = (&self.pipelines, &self.target) else { return Ok(0) };
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        let mut drawn = 0;
        {
            let mut pass = target.begin(&mut encoder, "surface", ends.first, ends.last);
            pass.set_bind_group(0, &self.bind_group, &[]);
            let mut state = None;
            let mut runs = runs.iter().peekable();
            while let Some(run) = runs.next() {
                // Neighbours on the GPU that are neighbours in the order are one draw.
                let mut count = run.count;
                let follows = |next: &&Run, count: u32| {
                    (next.placed, next.place.page) == (run.placed, run.place.page)
                        && run.place.first.checked_add(count) == Some(next.place.first)
                };
                while let Some(next) = runs.next_if(|next| follows(next, count)) {
                    count += next.count;
                }
                if count == 0 {
                    continue;
                }
                self.set_state(&mut pass, frame, run, &mut state);
                let range = run.place.first..run.place.first.saturating_add(count);
                let row = frame.rows.first + run.placed;
                if frame.paint.is_some() {
                    pass.draw(range, row..row + 1);
                } else {
                    pass.draw_indexed(range, 0, row..row + 1);
                }
                drawn += u64::from(count / 3);
            }
            if ends.last {
                // Where nothing was drawn: no pixel is shaded for nothing.
                pass.set_pipeline(&pipelines.background);
                pass.draw(0..3, 0..1);
            }
        }
        self.gpu.queue.submit([encoder.finish()]);
        Ok(drawn)
    }

    /// Sets pipeline and buffers for a run, where they differ from the last one's.
    fn set_state(&self, pass: &mut wgpu::RenderPass<'_>, frame: &Frame<'_>, run: &Run, state: &mut State) {
        let Some(pipelines) = &self.pipelines else { return };
        let look = match (frame.paint.is_some(), self.smooth.get(run.model)) {
            (true, _) => Look::Painted,
            (false, Some(true)) => Look::Smooth,
            (false, _) => Look::Flat,
        };
        let new = (look, run.model, run.place.page);
        let old = state.replace(new);
        if old == Some(new) {
            return;
        }
        let differs = |part: fn(&(Look, usize, usize)) -> usize| old.as_ref().map(part) != Some(part(&new));
        if old.map(|(look, ..)| look) != Some(look) {
            if let Some(pipeline) = pipelines.surface(look, frame.sides) {
                pass.set_pipeline(pipeline);
            }
            if let Some(rows) = self.rows.buffer(frame.rows.page) {
                pass.set_vertex_buffer(0, rows.slice(..));
            }
        }
        if look == Look::Painted {
            if let Some(corners) = self.corners.buffer(run.place.page) {
                pass.set_vertex_buffer(1, corners.slice(..));
            }
            return;
        }
        if differs(|(_, model, _)| *model)
            && let Some(vertices) = self.residency.buffer(run.model)
        {
            pass.set_vertex_buffer(1, vertices.slice(..));
        }
        if differs(|(_, _, page)| *page) {
            let pages = if self.draws_whole_models(frame) { &self.whole_indices } else { &self.indices };
            if let Some(indices) = pages.buffer(run.place.page) {
                pass.set_index_buffer(indices.slice(..), wgpu::IndexFormat::Uint32);
            }
        }
    }
}

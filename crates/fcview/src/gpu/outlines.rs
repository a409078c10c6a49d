//! The polygons that occlusion queries ask about, as lines over the picture.
//!
//! # Paper
//! [Tsuji07, fig. 8]: the bounding polygons of a model's clusters.

use super::device::Gpu;
use super::pages::Pages;
use super::pipelines::{OutlineVertex, Pipelines};
use super::target::Target;
use crate::Error;

/// What a polygon's line looks like, linear: red where what it encloses was found hidden, blue where it may show.
const HIDDEN: [u8; 4] = [255, 24, 8, 255];
const SHOWN: [u8; 4] = [16, 120, 255, 255];

/// Lines to draw over a picture.
pub(crate) struct Outlines {
    shown: Vec<OutlineVertex>,
    hidden: Vec<OutlineVertex>,
    pages: Pages,
}

impl Outlines {
    pub(crate) fn new() -> Outlines {
        let stride = size_of::<OutlineVertex>() as u64;
        let pages = Pages::new("outlines", stride, wgpu::BufferUsages::VERTEX);
        Outlines { shown: Vec::new(), hidden: Vec::new(), pages }
    }

    /// Forgets all lines.
    pub(crate) fn clear(&mut self) {
        self.shown.clear();
        self.hidden.clear();
    }

    /// Adds the sides of a polygon in clip space.
    pub(crate) fn add(&mut self, corners: &[[f32; 4]], hidden: bool) {
        let (lines, color) = if hidden { (&mut self.hidden, HIDDEN) } else { (&mut self.shown, SHOWN) };
        for (from, to) in corners.iter().zip(corners.iter().cycle().skip(1)) {
            lines.extend([from, to].map(|clip| OutlineVertex { clip: *clip, color }));
        }
    }

    /// Draws all lines over a picture that is complete but for them, those of hidden polygons on top.
    ///
    /// # Errors
    /// As [`Pages::push`].
    pub(crate) fn draw(&mut self, gpu: &Gpu, pipelines: &Pipelines, target: &Target) -> Result<(), Error> {
        let count = self.shown.len() + self.hidden.len();
        if count == 0 {
            return Ok(());
        }
        let data = [bytemuck::cast_slice(&self.shown), bytemuck::cast_slice(&self.hidden)];
        self.pages.restart(gpu, (count * size_of::<OutlineVertex>()) as u64);
        let place = self.pages.push(gpu, "the outlines", &data)?;
        let Some(buffer) = self.pages.buffer(place.page) else { return Ok(()) };
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        {
            let mut pass = target.begin(&mut encoder, "outlines", false, true);
            pass.set_pipeline(&pipelines.outlines);
            pass.set_vertex_buffer(0, buffer.slice(..));
            pass.draw(place.first..place.first.saturating_add(count as u32), 0..1);
        }
        gpu.queue.submit([encoder.finish()]);
        Ok(())
    }
}

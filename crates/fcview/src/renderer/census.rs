//! A count, triangle by triangle, of what shows: the oracle against which occlusion culling is measured.

use super::{Renderer, instance_row};
use crate::camera::Camera;
use crate::frame::pieces::{self, Piece};
use crate::gpu::census::{CORNER_BYTES, CensusPipelines, NUMBER_FORMAT};
use crate::gpu::pipelines::{InstanceRow, Sides};
use crate::gpu::readback;
use crate::gpu::target::Target;
use crate::options::FrameOptions;
use crate::scene::Scene;
use crate::stats::FrameStats;
use crate::{Error, Gpu};
use bytemuck::{Pod, Zeroable};

/// What became of a frame's triangles. Back faces and triangles that cover no pixel's centre count nowhere: the
/// rasteriser drops them whatever is before them.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Census {
    /// Triangles that cover the centre of a pixel at least.
    pub covering: u64,
    /// Those of them that show in a pixel of the picture.
    pub shown: u64,
    /// Those of them that the queries removed.
    pub removed: u64,
    /// Those of them that the queries removed though they show: none, if culling is exact.
    pub wrong: u64,
}

impl Census {
    /// Triangles that a test of every triangle would remove.
    pub fn oracle(&self) -> u64 {
        self.covering - self.shown
    }
}

/// A corner of a triangle, as `census.wgsl` reads it.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Corner {
    position: [f32; 3],
    number: u32,
}

const _: () = assert!(size_of::<Corner>() == CORNER_BYTES);

impl Renderer {
    /// Draws a frame of one sample a pixel as [`Renderer::draw`] does and counts its triangles. Slow, for tests.
    ///
    /// # Errors
    /// As [`Renderer::draw`].
    #[doc(hidden)]
    pub fn census(
        &mut self,
        scene: &Scene,
        camera: &Camera,
        options: &FrameOptions,
    ) -> Result<(Census, FrameStats), Error> {
        let stats = self.draw(scene, camera, options)?;
        let rows: Vec<InstanceRow> = self
            .plan
            .placed
            .iter()
            .filter_map(|placed| scene.instances.get(placed.instance))
            .map(|instance| instance_row(scene, instance, camera.eye))
            .collect();
        let mut corners = Vec::new();
        let mut ranges = Vec::new();
        let mut removed = Vec::new();
        let mut mesh = fcextract::Extraction::default();
        // In the order in which the frame draws them: of two triangles at one depth the first shows.
        let mut pieces: Vec<(Piece, bool)> = self.drawn.iter().map(|piece| (*piece, false)).collect();
        for hidden in &self.hidden {
            let divided = pieces::divide(scene, &self.plan, &[*hidden], &mut fcextract::Stats::default())?;
            pieces.extend(divided.into_iter().map(|piece| (piece, true)));
        }
        pieces.sort_by_key(|(piece, _)| piece.rank());
        for (piece, hidden) in pieces {
            let Some(placed) = self.plan.placed.get(piece.placed as usize) else { continue };
            let Some(model) = scene.models.get(placed.model) else { continue };
            mesh.clear();
            mesh.append(&model.tree, &placed.selection, &piece.part)
                .map_err(|source| Error::Extract { model: model.name.clone(), source })?;
            let start = corners.len() as u32;
            for (triangle, index) in mesh.indices.iter().enumerate().map(|(i, v)| (i / 3, v)) {
                let vertex = model.tree.vertices().get(*index as usize);
                let position = vertex.map_or([f32::NAN; 3], |v| v.position());
                corners.push(Corner { position, number: start / 3 + triangle as u32 });
            }
            ranges.push((start..corners.len() as u32, piece.placed));
            removed.resize(corners.len() / 3, hidden);
        }
        let sides = if options.two_sided { Sides::Both } else { Sides::Front };
        let passes = Passes::new(&self.gpu, options.size, &rows, &corners)?;
        let (shown, covering) = passes.run(self, sides, &ranges)?;
        let mut census = Census::default();
        for ((shown, covering), removed) in shown.iter().zip(&covering).zip(&removed) {
            census.covering += u64::from(*covering);
            census.shown += u64::from(*shown);
            census.removed += u64::from(*removed && *covering);
            census.wrong += u64::from(*removed && *shown);
        }
        Ok((census, stats))
    }
}

/// What the two passes read and write.
struct Passes {
    target: Target,
    numbers: wgpu::Texture,
    rows: wgpu::Buffer,
    corners: wgpu::Buffer,
    covering: wgpu::Buffer,
    staging: wgpu::Buffer,
    triangles: usize,
}

impl Passes {
    fn new(gpu: &Gpu, size: [u32; 2], rows: &[InstanceRow], corners: &[Corner]) -> Result<Passes, Error> {
        let filled = |data: &[u8]| {
            let usage = wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_DST;
            let buffer = buffer(gpu, data.len(), usage);
            gpu.queue.write_buffer(&buffer, 0, data);
            buffer
        };
        let target = Target::new(gpu, size, 1)?;
        let numbers = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("numbers"),
            size: target.depth.size(),
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: NUMBER_FORMAT,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let triangles = corners.len() / 3;
        let words = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
        let read = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
        Ok(Passes {
            target,
            numbers,
            rows: filled(bytemuck::cast_slice(rows)),
            corners: filled(bytemuck::cast_slice(corners)),
            covering: buffer(gpu, 4 * triangles, words),
            staging: buffer(gpu, 4 * triangles, read),
            triangles,
        })
    }

    /// Which triangles show, and which cover a pixel's centre.
    fn run(
        &self,
        renderer: &Renderer,
        sides: Sides,
        ranges: &[(std::ops::Range<u32>, u32)],
    ) -> Result<(Vec<bool>, Vec<bool>), Error> {
        let gpu = &renderer.gpu;
        let pipelines = CensusPipelines::new(&gpu.device, &renderer.frame_layout, sides);
        let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("census"),
            layout: &pipelines.layout,
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: self.covering.as_entire_binding() }],
        });
        let numbers = self.numbers.create_view(&Default::default());
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let color = wgpu::RenderPassColorAttachment {
            view: &numbers,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations {
                load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                store: wgpu::StoreOp::Store,
            },
        };
        let passes: [(&[_], _); 2] = [(&[Some(color)], &pipelines.shows), (&[], &pipelines.covers)];
        for (color_attachments, pipeline) in passes {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("census"),
                color_attachments,
                depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                    view: &self.target.depth_view,
                    depth_ops: Some(wgpu::Operations {
                        load: wgpu::LoadOp::Clear(0.0),
                        store: wgpu::StoreOp::Store,
                    }),
                    stencil_ops: None,
                }),
                ..Default::default()
            });
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &renderer.bind_group, &[]);
            pass.set_bind_group(1, &group, &[]);
            pass.set_vertex_buffer(0, self.rows.slice(..));
            pass.set_vertex_buffer(1, self.corners.slice(..));
            for (range, row) in ranges {
                pass.draw(range.clone(), *row..*row + 1);
            }
        }
        let bytes = 4 * self.triangles as u64;
        encoder.copy_buffer_to_buffer(&self.covering, 0, &self.staging, 0, bytes);
        gpu.queue.submit([encoder.finish()]);
        let words = |bytes: &[u8]| -> Vec<u32> {
            bytes.as_chunks::<4>().0.iter().map(|b| u32::from_le_bytes(*b)).collect()
        };
        let covering = words(&readback::buffer(gpu, &self.staging, bytes, "the census")?);
        let numbers = readback::texture(gpu, &self.numbers, self.target.size, wgpu::TextureAspect::All)?;
        let mut shown = vec![false; self.triangles];
        for number in words(&numbers) {
            let triangle = (number as usize).checked_sub(1);
            if let Some(flag) = triangle.and_then(|triangle| shown.get_mut(triangle)) {
                *flag = true;
            }
        }
        Ok((shown, covering.iter().map(|word| *word != 0).collect()))
    }
}

/// A buffer of so many bytes, and never none, which binding forbids.
fn buffer(gpu: &Gpu, bytes: usize, usage: wgpu::BufferUsages) -> wgpu::Buffer {
    gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("census"),
        size: (bytes as u64).max(64),
        usage,
        mapped_at_creation: false,
    })
}

//! Occlusion queries: which of many polygons would show against the depth drawn so far.
//!
//! # Paper
//! [Tsuji07, 5.3]: "a visibility test is performed for the polygons enclosing clusters".
//!
//! # Deviations
//! The depth tested against is that of surfaces really drawn in this frame, not that of a rough model, which
//! may stick out of the surface by its error and hide what shows.

use super::device::Gpu;
use super::pipelines::Pipelines;
use super::readback;
use super::target::Target;
use crate::Error;
use std::ops::Range;

/// Queries in a pass and in a query set.
///
/// More in one pass has been seen to give wrong (harmless, "visible") answers on Mesa's software Vulkan, and
/// very many to stall mobile GPUs; a pass costs little.
const QUERIES_PER_PASS: u32 = 256;

/// Bytes of one query's answer.
const ANSWER: u64 = size_of::<u64>() as u64;

/// The query sets and buffers, kept from frame to frame.
#[derive(Default)]
pub(crate) struct OcclusionQueries {
    sets: Vec<wgpu::QuerySet>,
    vertices: Option<wgpu::Buffer>,
    answers: Option<Answers>,
}

struct Answers {
    resolved: wgpu::Buffer,
    staging: wgpu::Buffer,
}

/// Convex polygons in clip space, to be asked about.
#[derive(Default)]
pub(crate) struct PolygonList {
    triangles: Vec<[f32; 4]>,
    ranges: Vec<Range<u32>>,
}

impl PolygonList {
    /// Adds a convex polygon.
    pub(crate) fn push(&mut self, corners: &[[f32; 4]]) {
        let start = self.triangles.len() as u32;
        if let [first, rest @ ..] = corners {
            for pair in rest.windows(2) {
                self.triangles.push(*first);
                self.triangles.extend_from_slice(pair);
            }
        }
        self.ranges.push(start..self.triangles.len() as u32);
    }

    /// The number of polygons.
    pub(crate) fn len(&self) -> usize {
        self.ranges.len()
    }
}

impl OcclusionQueries {
    /// Asks for every polygon whether any sample of it passes against the target's depth, and waits.
    ///
    /// The answer is true where in doubt.
    ///
    /// # Errors
    /// What [`Gpu::wait`] says.
    pub(crate) fn visible(
        &mut self,
        gpu: &Gpu,
        pipelines: &Pipelines,
        target: &Target,
        polygons: &PolygonList,
    ) -> Result<Vec<bool>, Error> {
        if polygons.len() == 0 {
            return Ok(Vec::new());
        }
        let passes = polygons.len().div_ceil(QUERIES_PER_PASS as usize);
        self.grow(gpu, polygons, passes);
        let (Some(vertices), Some(answers)) = (&self.vertices, &self.answers) else {
            return Ok(vec![true; polygons.len()]);
        };
        gpu.queue.write_buffer(vertices, 0, bytemuck::cast_slice(&polygons.triangles));

        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let chunks = polygons.ranges.chunks(QUERIES_PER_PASS as usize);
        for ((ranges, set), number) in chunks.zip(&self.sets).zip(0_u64..) {
            query_pass(&mut encoder, pipelines, target, set, vertices, ranges);
            // Resolving wants offsets in multiples of 256 bytes, which whole sets are.
            let offset = number * u64::from(QUERIES_PER_PASS) * ANSWER;
            encoder.resolve_query_set(set, 0..ranges.len() as u32, &answers.resolved, offset);
        }
        let bytes = polygons.len() as u64 * ANSWER;
        encoder.copy_buffer_to_buffer(&answers.resolved, 0, &answers.staging, 0, bytes);
        gpu.queue.submit([encoder.finish()]);
        let data = readback::buffer(gpu, &answers.staging, bytes, "the occlusion queries");
        if data.is_err() {
            // The staging buffer may still be waiting for its map; it must not be used again.
            self.answers = None;
        }
        let mut visible: Vec<bool> =
            data?.as_chunks::<8>().0.iter().map(|answer| u64::from_le_bytes(*answer) != 0).collect();
        visible.resize(polygons.len(), true);
        Ok(visible)
    }

    /// Makes room for the polygons.
    fn grow(&mut self, gpu: &Gpu, polygons: &PolygonList, passes: usize) {
        while self.sets.len() < passes {
            self.sets.push(gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("occlusion"),
                ty: wgpu::QueryType::Occlusion,
                count: QUERIES_PER_PASS,
            }));
        }
        let make = |label, size: u64, usage| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage,
                mapped_at_creation: false,
            })
        };
        let bytes = size_of_val(polygons.triangles.as_slice()) as u64;
        if self.vertices.as_ref().is_none_or(|buffer| buffer.size() < bytes) {
            let usage = wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_DST;
            self.vertices = Some(make("bounding polygons", bytes.next_power_of_two().max(4096), usage));
        }
        let bytes = passes as u64 * u64::from(QUERIES_PER_PASS) * ANSWER;
        if self.answers.as_ref().is_none_or(|answers| answers.resolved.size() < bytes) {
            let source = wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC;
            let staging = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
            let bytes = bytes.next_power_of_two();
            self.answers = Some(Answers {
                resolved: make("answers", bytes, source),
                staging: make("answers read-back", bytes, staging),
            });
        }
    }
}

/// One pass that asks about up to [`QUERIES_PER_PASS`] polygons and writes nothing.
fn query_pass(
    encoder: &mut wgpu::CommandEncoder,
    pipelines: &Pipelines,
    target: &Target,
    set: &wgpu::QuerySet,
    vertices: &wgpu::Buffer,
    ranges: &[Range<u32>],
) {
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("occlusion queries"),
        color_attachments: &[],
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: &target.depth_view,
            depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store }),
            stencil_ops: None,
        }),
        occlusion_query_set: Some(set),
        ..Default::default()
    });
    pass.set_pipeline(&pipelines.bounding_polygon);
    pass.set_vertex_buffer(0, vertices.slice(..));
    for (range, query) in ranges.iter().zip(0_u32..) {
        pass.begin_occlusion_query(query);
        if !range.is_empty() {
            pass.draw(range.clone(), 0..1);
        }
        pass.end_occlusion_query();
    }
}

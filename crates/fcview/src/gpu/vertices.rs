//! A model's vertices as the GPU reads them.

use super::device::Gpu;
use super::pipelines::SurfaceVertex;
use rayon::prelude::*;

/// The colour of models that store none: pale clay, sRGB.
pub(crate) const CLAY: [u8; 4] = [196, 186, 172, 255];

/// Vertices converted and handed to the driver at a time: large enough to keep the calls few, small enough to
/// keep the copies in the cache.
const CHUNK: usize = 1 << 15;

/// Bytes of a vertex on the GPU.
pub(crate) const VERTEX_BYTES: u64 = size_of::<SurfaceVertex>() as u64;

/// Where the vertices of a tree come from.
#[derive(Clone, Copy)]
pub(crate) struct Vertices<'a> {
    records: &'a [fct::VertexRecord],
    normals: Option<&'a [fct::NormalRecord]>,
    colors: Option<&'a [[u8; 4]]>,
}

impl<'a> Vertices<'a> {
    /// Those of a tree.
    pub(crate) fn of(tree: &'a fct::Tree) -> Vertices<'a> {
        Vertices { records: tree.vertices(), normals: tree.normals(), colors: tree.colors() }
    }

    /// One of them; a vertex of zeros if it is not there.
    pub(crate) fn get(&self, index: usize) -> SurfaceVertex {
        let Some(record) = self.records.get(index) else { return SurfaceVertex::default() };
        let normal = self.normals.and_then(|normals| normals.get(index));
        let color = self.colors.and_then(|colors| colors.get(index));
        SurfaceVertex {
            position: record.position(),
            normal: normal.map_or([0; 2], |n| n.uv.map(widen)),
            color: color.copied().unwrap_or(CLAY),
        }
    }

    /// A buffer with all of them, in the tree's order; its size is within what the adapter allows.
    pub(crate) fn upload(&self, gpu: &Gpu, name: &str) -> wgpu::Buffer {
        let count = self.records.len();
        let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(name),
            size: (count as u64).max(1) * VERTEX_BYTES,
            usage: wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        for start in (0..count).step_by(CHUNK) {
            let end = count.min(start + CHUNK);
            let data: Vec<SurfaceVertex> = (start..end).into_par_iter().map(|i| self.get(i)).collect();
            gpu.queue.write_buffer(&buffer, start as u64 * VERTEX_BYTES, bytemuck::cast_slice(&data));
        }
        buffer
    }
}

/// The coordinate that the GPU reads as the same fraction: it takes 1/32767 for 1/127.
fn widen(c: i8) -> i16 {
    (f32::from(c.max(-127)) * (32767.0 / 127.0)).round() as i16
}

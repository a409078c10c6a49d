//! A model's vertices on the GPU.

use super::device::Gpu;
use crate::Error;

/// Vertices of a model: three streams, so that each may be as large as the adapter's largest buffer.
pub(crate) struct GpuMesh {
    pub(crate) positions: wgpu::Buffer,
    pub(crate) normals: wgpu::Buffer,
    pub(crate) colors: wgpu::Buffer,
    pub(crate) has_normals: bool,
}

/// The colour of models that store none: pale clay, sRGB.
pub(crate) const CLAY: [u8; 4] = [196, 186, 172, 255];

/// Vertices converted and handed to the driver at a time: large enough to keep the calls few, small enough to
/// keep the copies in the cache.
const CHUNK: usize = 1 << 15;

impl GpuMesh {
    /// Uploads a tree's vertices.
    ///
    /// # Errors
    /// [`Error::BufferSize`] if a stream is larger than the adapter's largest buffer.
    pub(crate) fn upload(gpu: &Gpu, name: &str, tree: &fct::Tree) -> Result<GpuMesh, Error> {
        let vertices = tree.vertices();
        let count = vertices.len();
        let positions = stream(gpu, name, count, 12)?;
        for (chunk, offset) in vertices.chunks(CHUNK).zip((0_u64..).step_by(CHUNK * 12)) {
            let data: Vec<[f32; 3]> = chunk.iter().map(fct::VertexRecord::position).collect();
            gpu.queue.write_buffer(&positions, offset, bytemuck::cast_slice(&data));
        }
        let normals = stream(gpu, name, count, 4)?;
        let stored = tree.normals();
        for (chunk, offset) in stored.unwrap_or(&[]).chunks(CHUNK).zip((0_u64..).step_by(CHUNK * 4)) {
            let data: Vec<[i16; 2]> = chunk.iter().map(|n| n.uv.map(widen)).collect();
            gpu.queue.write_buffer(&normals, offset, bytemuck::cast_slice(&data));
        }
        let colors = stream(gpu, name, count, 4)?;
        match tree.colors() {
            Some(stored) => {
                for (chunk, offset) in stored.chunks(CHUNK).zip((0_u64..).step_by(CHUNK * 4)) {
                    gpu.queue.write_buffer(&colors, offset, chunk.as_flattened());
                }
            }
            None => {
                let clay = vec![CLAY; count.min(CHUNK)];
                for start in (0..count).step_by(CHUNK) {
                    let data = clay.get(..(count - start).min(CHUNK)).unwrap_or(&clay);
                    gpu.queue.write_buffer(&colors, start as u64 * 4, data.as_flattened());
                }
            }
        }
        Ok(GpuMesh { positions, normals, colors, has_normals: stored.is_some() })
    }
}

/// The coordinate that the GPU reads as the same fraction: it takes 1/32767 for 1/127.
fn widen(c: i8) -> i16 {
    (f32::from(c.max(-127)) * (32767.0 / 127.0)).round() as i16
}

/// An empty vertex buffer of `count` elements.
fn stream(gpu: &Gpu, name: &str, count: usize, stride: u64) -> Result<wgpu::Buffer, Error> {
    let bytes = (count as u64).saturating_mul(stride).max(stride);
    let limit = gpu.limits().max_buffer_size;
    if bytes > limit {
        return Err(Error::BufferSize {
            what: format!("{name}: a stream of {count} vertices"),
            bytes,
            limit,
            remedy: "split the model into several files",
        });
    }
    Ok(gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(name),
        size: bytes,
        usage: wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    }))
}

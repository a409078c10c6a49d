//! Textures and buffers back to the CPU.

use super::device::Gpu;
use super::target::Target;
use crate::Error;

/// Copies the finished picture out: RGBA, 8 bits a channel, sRGB, rows from the top.
pub(crate) fn picture(gpu: &Gpu, target: &Target) -> Result<Vec<u8>, Error> {
    texture(gpu, &target.picture, target.size, wgpu::TextureAspect::All)
}

/// Copies the depth out, where the target has one sample a pixel and the adapter allows it: near plane 1, nothing
/// drawn 0.
pub(crate) fn depth(gpu: &Gpu, target: &Target) -> Result<Option<Vec<f32>>, Error> {
    if target.samples > 1 || !gpu.copies_depth() {
        return Ok(None);
    }
    let bytes = texture(gpu, &target.depth, target.size, wgpu::TextureAspect::DepthOnly)?;
    Ok(Some(bytes.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect()))
}

/// Reads depths of one sample a pixel, as rows of so many numbers; the buffer is kept for the next time.
pub(crate) fn depth_rows(
    gpu: &Gpu,
    target: &Target,
    staging: &mut Option<wgpu::Buffer>,
    read: impl FnOnce(&[f32], usize),
) -> Result<(), Error> {
    let (row, bytes) = padded(target.size);
    let kept = staging.take().filter(|buffer| buffer.size() == bytes);
    let buffer = kept.unwrap_or_else(|| staging_buffer(gpu, bytes));
    submit_copy(gpu, &target.depth, target.size, wgpu::TextureAspect::DepthOnly, &buffer);
    mapped(gpu, &buffer, bytes, "the depth's read-back", |bytes| {
        read(bytemuck::cast_slice(bytes), row as usize / size_of::<f32>());
    })?;
    // One whose map has failed may still be waiting for it and is not used again.
    *staging = Some(buffer);
    Ok(())
}

/// Copies out a texture of 4 bytes a pixel, without padding between rows.
pub(crate) fn texture(
    gpu: &Gpu,
    texture: &wgpu::Texture,
    [width, height]: [u32; 2],
    aspect: wgpu::TextureAspect,
) -> Result<Vec<u8>, Error> {
    let row = width * 4;
    let (padded, bytes) = padded([width, height]);
    let staging = staging_buffer(gpu, bytes);
    submit_copy(gpu, texture, [width, height], aspect, &staging);
    let padded_rows = buffer(gpu, &staging, bytes, "the picture's read-back")?;
    let mut rows = Vec::with_capacity(row as usize * height as usize);
    for line in padded_rows.chunks_exact(padded as usize) {
        rows.extend_from_slice(line.get(..row as usize).unwrap_or(line));
    }
    Ok(rows)
}

/// Bytes of a row of 4 bytes a pixel as textures are copied, and of all rows.
fn padded([width, height]: [u32; 2]) -> (u32, u64) {
    let row = (width * 4).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    (row, u64::from(row) * u64::from(height))
}

fn staging_buffer(gpu: &Gpu, bytes: u64) -> wgpu::Buffer {
    gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("read-back"),
        size: bytes,
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

fn submit_copy(
    gpu: &Gpu,
    texture: &wgpu::Texture,
    [width, height]: [u32; 2],
    aspect: wgpu::TextureAspect,
    to: &wgpu::Buffer,
) {
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    encoder.copy_texture_to_buffer(
        wgpu::TexelCopyTextureInfo { texture, mip_level: 0, origin: wgpu::Origin3d::ZERO, aspect },
        wgpu::TexelCopyBufferInfo {
            buffer: to,
            layout: wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(padded([width, height]).0),
                rows_per_image: Some(height),
            },
        },
        wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
    );
    gpu.queue.submit([encoder.finish()]);
}

/// Waits for the GPU and copies the first `bytes` bytes of a mappable buffer out.
pub(crate) fn buffer(
    gpu: &Gpu,
    staging: &wgpu::Buffer,
    bytes: u64,
    what: &'static str,
) -> Result<Vec<u8>, Error> {
    if bytes == 0 {
        return Ok(Vec::new());
    }
    mapped(gpu, staging, bytes, what, <[u8]>::to_vec)
}

/// Waits for the GPU and reads the first `bytes` bytes, some at least, of a mappable buffer.
fn mapped<T>(
    gpu: &Gpu,
    staging: &wgpu::Buffer,
    bytes: u64,
    what: &'static str,
    read: impl FnOnce(&[u8]) -> T,
) -> Result<T, Error> {
    let slice = staging.slice(..bytes);
    // The view below says whether mapping worked, so the callback has nothing to add.
    slice.map_async(wgpu::MapMode::Read, |_| {});
    gpu.wait(what)?;
    let read = match slice.get_mapped_range() {
        Ok(view) => read(&view),
        Err(error) => return Err(Error::Device { message: format!("{what}: {error}") }),
    };
    staging.unmap();
    Ok(read)
}

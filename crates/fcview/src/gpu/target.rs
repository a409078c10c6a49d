//! What is drawn into: a colour and a depth texture of one size and sample count.

use super::device::Gpu;
use crate::Error;

/// The colour format of pictures: 8 bits a channel, sRGB encoded.
pub(crate) const COLOR_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;

/// The depth format; depth is reversed (1 at the near plane, 0 at infinity), where 32-bit floats have the same
/// relative precision at every distance.
pub(crate) const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// The textures of a picture.
pub(crate) struct Target {
    pub(crate) size: [u32; 2],
    pub(crate) samples: u32,
    /// One sample a pixel; the finished picture.
    pub(crate) picture: wgpu::Texture,
    pub(crate) picture_view: wgpu::TextureView,
    /// Several samples a pixel, where asked for; resolved into the picture.
    multisampled: Option<wgpu::TextureView>,
    pub(crate) depth: wgpu::Texture,
    pub(crate) depth_view: wgpu::TextureView,
}

impl Target {
    /// Makes the textures.
    ///
    /// # Errors
    /// [`Error::PictureSize`] if the adapter cannot make textures of this size.
    pub(crate) fn new(gpu: &Gpu, size: [u32; 2], samples: u32) -> Result<Target, Error> {
        let limit = gpu.limits().max_texture_dimension_2d;
        let [width, height] = size;
        if width == 0 || height == 0 || width > limit || height > limit {
            return Err(Error::PictureSize { width, height, limit });
        }
        let texture = |label, format, samples, usage| {
            gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: samples,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage,
                view_formats: &[],
            })
        };
        let attachment = wgpu::TextureUsages::RENDER_ATTACHMENT;
        let source = wgpu::TextureUsages::COPY_SRC;
        let picture =
            texture("picture", COLOR_FORMAT, 1, attachment | source | wgpu::TextureUsages::TEXTURE_BINDING);
        let multisampled = (samples > 1)
            .then(|| texture("samples", COLOR_FORMAT, samples, attachment).create_view(&Default::default()));
        let depth_usage = if samples > 1 { attachment } else { attachment | source };
        let depth = texture("depth", DEPTH_FORMAT, samples, depth_usage);
        Ok(Target {
            size,
            samples,
            picture_view: picture.create_view(&Default::default()),
            picture,
            multisampled,
            depth_view: depth.create_view(&Default::default()),
            depth,
        })
    }

    /// Begins a pass that draws colour and depth, clearing both on the first pass of a picture.
    pub(crate) fn begin<'a>(
        &'a self,
        encoder: &'a mut wgpu::CommandEncoder,
        label: &'static str,
        first: bool,
        last: bool,
    ) -> wgpu::RenderPass<'a> {
        let (view, resolve_target) = match &self.multisampled {
            Some(view) => (view, last.then_some(&self.picture_view)),
            None => (&self.picture_view, None),
        };
        let color_load = if first { wgpu::LoadOp::Clear(wgpu::Color::BLACK) } else { wgpu::LoadOp::Load };
        let depth_load = if first { wgpu::LoadOp::Clear(0.0) } else { wgpu::LoadOp::Load };
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(label),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target,
                ops: wgpu::Operations { load: color_load, store: wgpu::StoreOp::Store },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depth_view,
                depth_ops: Some(wgpu::Operations { load: depth_load, store: wgpu::StoreOp::Store }),
                stencil_ops: None,
            }),
            ..Default::default()
        })
    }
}

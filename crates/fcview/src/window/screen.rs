//! The window's surface: the picture and the panel drawn over it, and everything that can happen to a surface.

use crate::error::built_backends;
use crate::renderer::Renderer;
use crate::{Error, Gpu, Scene};
use egui::ViewportId;
use std::sync::Arc;
use std::time::{Duration, Instant};
use winit::event_loop::OwnedDisplayHandle;
use winit::window::Window;

/// How long a surface of one size may refuse every frame before the run gives up. While a window is resized it
/// refuses most of them, being of another size by the time that they are drawn.
const PATIENCE: Duration = Duration::from_secs(20);

/// The window with all that draws into it.
///
/// The order of the fields is the order in which they go: the surface before the window that it belongs to.
pub(super) struct Screen {
    pub(super) renderer: Renderer,
    egui_renderer: egui_wgpu::Renderer,
    present: wgpu::RenderPipeline,
    present_layout: wgpu::BindGroupLayout,
    surface: wgpu::Surface<'static>,
    config: wgpu::SurfaceConfiguration,
    /// Whether the surface has been given a size; before, asking it for a frame panics.
    configured: bool,
    /// Since when the surface has refused every frame.
    refusing: Option<Instant>,
    pub(super) egui: egui_winit::State,
    pub(super) window: Arc<Window>,
}

/// The panel, ready to be drawn.
pub(super) struct Overlay {
    pub(super) textures: egui::TexturesDelta,
    pub(super) shapes: Vec<egui::ClippedPrimitive>,
    pub(super) pixels_per_point: f32,
}

/// What became of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shown {
    /// It is on the screen.
    Yes,
    /// It is not; draw again.
    Again,
    /// The window is hidden or has no size; wait for an event.
    Hidden,
}

impl Screen {
    /// Opens a device that can draw to the window, with so many bytes for the scene's vertices.
    pub(super) fn open(
        window: Arc<Window>,
        display: &OwnedDisplayHandle,
        scene: &Scene,
        gpu_memory: Option<u64>,
    ) -> Result<Screen, Error> {
        let (gpu, surface) = crate::gpu::first_that_works(|backends| {
            let handle = Box::new(display.clone());
            let mut descriptor = wgpu::InstanceDescriptor::new_with_display_handle_from_env(handle);
            descriptor.backends = backends;
            let instance = wgpu::Instance::new(descriptor);
            let surface =
                make_surface(&instance, &window).map_err(|error| refusal(error, &instance, backends))?;
            Ok((Gpu::from_instance(instance, Some(&surface), backends)?, surface))
        })
        .map_err(Error::with_backends_asked_for)?;
        let size = window.inner_size();
        let mut config = surface
            .get_default_config(&gpu.adapter, size.width.max(1), size.height.max(1))
            .ok_or_else(|| Error::NoWindow { reason: "the adapter cannot draw to it".to_owned() })?;
        // A format that does not encode sRGB itself: the panel's colours are blended as they are.
        let formats = surface.get_capabilities(&gpu.adapter).formats;
        if let Some(plain) = formats.iter().find(|format| {
            matches!(format, wgpu::TextureFormat::Bgra8Unorm | wgpu::TextureFormat::Rgba8Unorm)
        }) {
            config.format = *plain;
        }
        config.present_mode = wgpu::PresentMode::AutoVsync;
        let (present, present_layout) = present_pipeline(&gpu.device, config.format);
        let egui_renderer = egui_wgpu::Renderer::new(&gpu.device, config.format, Default::default());
        let limit = gpu.limits().max_texture_dimension_2d;
        let context = egui::Context::default();
        context.set_theme(egui::Theme::Dark);
        let egui = egui_winit::State::new(
            context,
            ViewportId::ROOT,
            &window,
            Some(window.scale_factor() as f32),
            None,
            Some(limit as usize),
        );
        let renderer = Renderer::with_memory(gpu, scene, gpu_memory)?;
        let mut screen = Screen {
            renderer,
            egui_renderer,
            present,
            present_layout,
            surface,
            config,
            configured: false,
            refusing: None,
            egui,
            window,
        };
        screen.resize();
        screen.renderer.gpu().check()?;
        Ok(screen)
    }

    /// The size of pictures for this window, or `None` while it has none.
    pub(super) fn size(&self) -> Option<[u32; 2]> {
        let limit = self.renderer.gpu().limits().max_texture_dimension_2d;
        picture_size(self.window.inner_size().into(), limit)
    }

    /// Takes over the window's size.
    pub(super) fn resize(&mut self) {
        // A surface must not be configured to no size, as that of a minimised window.
        if let Some([width, height]) = self.size() {
            if [width, height] != [self.config.width, self.config.height] {
                self.refusing = None;
            }
            self.config.width = width;
            self.config.height = height;
            self.surface.configure(&self.renderer.gpu().device, &self.config);
            self.configured = true;
        }
    }

    /// Shows the renderer's picture under the panel.
    pub(super) fn show(&mut self, overlay: Overlay) -> Result<Shown, Error> {
        let gpu = self.renderer.gpu();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let screen = egui_wgpu::ScreenDescriptor {
            size_in_pixels: [self.config.width, self.config.height],
            pixels_per_point: overlay.pixels_per_point,
        };
        // Textures come even when the frame cannot be shown: they are sent once.
        #[allow(clippy::iter_over_hash_type, reason = "each entry is a texture of its own")]
        for (id, deltas) in &overlay.textures.set {
            for delta in deltas {
                self.egui_renderer.update_texture(&gpu.device, &gpu.queue, *id, delta);
            }
        }
        if !self.configured {
            return Ok(Shown::Hidden);
        }
        let frame = match self.surface.get_current_texture() {
            wgpu::CurrentSurfaceTexture::Success(frame) => frame,
            wgpu::CurrentSurfaceTexture::Suboptimal(frame) => {
                drop(frame);
                return self.refuse(true);
            }
            wgpu::CurrentSurfaceTexture::Outdated => return self.refuse(true),
            wgpu::CurrentSurfaceTexture::Timeout => return self.refuse(false),
            wgpu::CurrentSurfaceTexture::Occluded => return Ok(Shown::Hidden),
            wgpu::CurrentSurfaceTexture::Lost => {
                self.surface = make_surface(&gpu.instance, &self.window)?;
                self.configured = false;
                return self.refuse(true);
            }
            wgpu::CurrentSurfaceTexture::Validation => {
                gpu.check()?;
                return self.refuse(true);
            }
        };
        let view = frame.texture.create_view(&Default::default());
        let picture = self.renderer.picture().map(|picture| {
            gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("picture"),
                layout: &self.present_layout,
                entries: &[wgpu::BindGroupEntry {
                    binding: 0,
                    resource: wgpu::BindingResource::TextureView(picture),
                }],
            })
        });
        let mut commands = self.egui_renderer.update_buffers(
            &gpu.device,
            &gpu.queue,
            &mut encoder,
            &overlay.shapes,
            &screen,
        );
        {
            let pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("screen"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: &view,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations {
                        load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                        store: wgpu::StoreOp::Store,
                    },
                })],
                ..Default::default()
            });
            let mut pass = pass.forget_lifetime();
            if let Some(picture) = &picture {
                pass.set_pipeline(&self.present);
                pass.set_bind_group(0, picture, &[]);
                pass.draw(0..3, 0..1);
            }
            self.egui_renderer.render(&mut pass, &overlay.shapes, &screen);
        }
        commands.push(encoder.finish());
        gpu.queue.submit(commands);
        self.window.pre_present_notify();
        gpu.queue.present(frame);
        #[allow(clippy::iter_over_hash_type, reason = "each entry is a texture of its own")]
        for id in &overlay.textures.free {
            self.egui_renderer.free_texture(id);
        }
        self.refusing = None;
        gpu.check()?;
        Ok(Shown::Yes)
    }

    /// A frame that the surface refused: once more, with the surface made ready again, but not for ever.
    fn refuse(&mut self, configure: bool) -> Result<Shown, Error> {
        if self.refusing.get_or_insert_with(Instant::now).elapsed() > PATIENCE {
            return Err(Error::NoWindow { reason: "its surface refuses every frame".to_owned() });
        }
        if self.size().is_none() {
            return Ok(Shown::Hidden);
        }
        if configure {
            self.resize();
        }
        Ok(Shown::Again)
    }
}

/// The size of a picture for a window: none for one that is minimised, no larger than the adapter can draw.
fn picture_size([width, height]: [u32; 2], limit: u32) -> Option<[u32; 2]> {
    (width > 0 && height > 0).then_some([width.min(limit), height.min(limit)])
}

fn make_surface(instance: &wgpu::Instance, window: &Arc<Window>) -> Result<wgpu::Surface<'static>, Error> {
    instance.create_surface(Arc::clone(window)).map_err(|error| Error::NoWindow { reason: error.to_string() })
}

/// Why there is no surface: without any adapter that is the reason, and other backends may have one.
fn refusal(error: Error, instance: &wgpu::Instance, backends: wgpu::Backends) -> Error {
    if pollster::block_on(instance.enumerate_adapters(backends)).is_empty() {
        Error::NoAdapter { backends: built_backends(backends) }
    } else {
        error
    }
}

/// The pipeline that copies the picture to the surface.
fn present_pipeline(
    device: &wgpu::Device,
    format: wgpu::TextureFormat,
) -> (wgpu::RenderPipeline, wgpu::BindGroupLayout) {
    let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("picture"),
        entries: &[wgpu::BindGroupLayoutEntry {
            binding: 0,
            visibility: wgpu::ShaderStages::FRAGMENT,
            ty: wgpu::BindingType::Texture {
                sample_type: wgpu::TextureSampleType::Float { filterable: false },
                view_dimension: wgpu::TextureViewDimension::D2,
                multisampled: false,
            },
            count: None,
        }],
    });
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("present"),
        source: wgpu::ShaderSource::Wgsl(include_str!("../shaders/present.wgsl").into()),
    });
    let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("present"),
        bind_group_layouts: &[Some(&layout)],
        immediate_size: 0,
    });
    // Where only formats that encode sRGB themselves exist, the shader must not do it again.
    let constants = [("encode", if format.is_srgb() { 0.0 } else { 1.0 })];
    let options = wgpu::PipelineCompilationOptions { constants: &constants, ..Default::default() };
    let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("present"),
        layout: Some(&pipeline_layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("vertex"),
            compilation_options: options.clone(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: None,
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("fragment"),
            compilation_options: options,
            targets: &[Some(format.into())],
        }),
        multiview_mask: None,
        cache: None,
    });
    (pipeline, layout)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_window_without_a_size_has_no_picture_and_a_huge_one_as_much_as_can_be() {
        for (window, picture) in [
            ([0, 0], None),
            ([0, 5], None),
            ([5, 0], None),
            ([1, 1], Some([1, 1])),
            ([640, 100_000], Some([640, 8192])),
        ] {
            assert_eq!(picture_size(window, 8192), picture);
        }
    }
}

//! The renderer: a scene on a device, frame after frame.

mod census;
mod distances;
mod fitting;
mod geometry;
mod passes;
mod rounds;

pub use census::Census;

use crate::camera::{Camera, View};
use crate::frame::corners::{Paint, PaintColor};
use crate::frame::depths::Depths;
use crate::frame::meshes::Meshes;
use crate::frame::pieces::Piece;
use crate::frame::plan::Plan;
use crate::gpu::occlusion::OcclusionQueries;
use crate::gpu::outlines::Outlines;
use crate::gpu::pages::{Pages, Place};
use crate::gpu::pipelines::{self, ClusterVertex, FrameUniform, InstanceRow, Kind, Pipelines, Sides};
use crate::gpu::readback;
use crate::gpu::target::Target;
use crate::options::{ColorMode, Detail, FrameOptions};
use crate::residency::Residency;
use crate::scene::{Instance, Scene};
use crate::stats::FrameStats;
use crate::{Error, Gpu, Image};
use glam::DVec3;
use std::time::Instant;

/// Draws frames of one scene.
pub struct Renderer {
    gpu: Gpu,
    residency: Residency,
    /// Whether each model stores normals.
    smooth: Vec<bool>,
    frame_layout: wgpu::BindGroupLayout,
    uniform: wgpu::Buffer,
    bind_group: wgpu::BindGroup,
    pipelines: Option<Pipelines>,
    target: Option<Target>,
    indices: Pages,
    corners: Pages,
    rows: Pages,
    /// All faces of the models, by model, for frames that draw them as they are.
    whole: Vec<Option<Place>>,
    whole_indices: Pages,
    /// Whether the driver is a program on the CPU.
    software: bool,
    queries: OcclusionQueries,
    /// The depth drawn so far, and whether anything was drawn since it was read.
    depths: Depths,
    depths_are_current: bool,
    depth_staging: Option<wgpu::Buffer>,
    outlines: Outlines,
    cuts: Meshes,
    fitter: fcextract::Fitter,
    /// The last frame's plan, and its pieces that were drawn and that were found hidden.
    plan: Plan,
    drawn: Vec<Piece>,
    hidden: Vec<Piece>,
    frames: u32,
}

/// What a frame's stages share.
struct Frame<'a> {
    scene: &'a Scene,
    view: &'a View,
    plan: &'a Plan,
    options: &'a FrameOptions,
    rows: Place,
    sides: Sides,
    /// What is painted on unindexed triangles; none where triangles are indexed.
    paint: Option<Paint>,
}

/// A run of triangles of one instance on the GPU.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Run {
    placed: u32,
    model: usize,
    place: Place,
    /// Corners, three a triangle.
    count: u32,
}

impl Renderer {
    /// A renderer with as many of the scene's vertices on the GPU as the adapter allows.
    ///
    /// # Errors
    /// What the driver says.
    pub fn new(gpu: Gpu, scene: &Scene) -> Result<Renderer, Error> {
        Renderer::with_memory(gpu, scene, None)
    }

    /// A renderer whose vertices take no more than so many bytes of the GPU's memory. Where that is not enough for all
    /// of the scene, those that a frame draws are uploaded, and a frame that needs more is drawn coarser.
    ///
    /// # Errors
    /// [`Error::GpuMemory`] if that is not enough for a triangle, or what the driver says.
    pub fn with_memory(gpu: Gpu, scene: &Scene, bytes: Option<u64>) -> Result<Renderer, Error> {
        let frame_layout = pipelines::frame_layout(&gpu.device);
        let uniform = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("frame"),
            size: size_of::<FrameUniform>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let bind_group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("frame"),
            layout: &frame_layout,
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: uniform.as_entire_binding() }],
        });
        let residency = Residency::new(&gpu, scene, bytes)?;
        gpu.check()?;
        Ok(Renderer {
            indices: Pages::new("indices", 4, wgpu::BufferUsages::INDEX),
            whole: Vec::new(),
            whole_indices: Pages::new("all faces", 4, wgpu::BufferUsages::INDEX),
            corners: Pages::new("corners", size_of::<ClusterVertex>() as u64, wgpu::BufferUsages::VERTEX),
            rows: Pages::new("instances", size_of::<InstanceRow>() as u64, wgpu::BufferUsages::VERTEX),
            software: gpu.is_software(),
            gpu,
            residency,
            smooth: scene.models.iter().map(|model| model.tree.normals().is_some()).collect(),
            frame_layout,
            uniform,
            bind_group,
            pipelines: None,
            target: None,
            queries: OcclusionQueries::default(),
            depths: Depths::default(),
            depths_are_current: false,
            depth_staging: None,
            outlines: Outlines::new(),
            cuts: Meshes::default(),
            fitter: fcextract::Fitter::default(),
            plan: Plan::default(),
            drawn: Vec::new(),
            hidden: Vec::new(),
            frames: 0,
        })
    }

    /// The device.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// Draws a frame and reads it back.
    ///
    /// # Errors
    /// As [`Renderer::draw`].
    pub fn render(
        &mut self,
        scene: &Scene,
        camera: &Camera,
        options: &FrameOptions,
    ) -> Result<(Image, FrameStats), Error> {
        let stats = self.draw(scene, camera, options)?;
        Ok((self.image(options.depth)?, stats))
    }

    /// Draws a frame of the scene that this renderer was made for; the picture stays on the GPU.
    ///
    /// # Errors
    /// [`Error::Camera`], [`Error::PictureSize`], [`Error::BufferSize`], [`Error::Extract`], or what the driver says.
    pub fn draw(
        &mut self,
        scene: &Scene,
        camera: &Camera,
        options: &FrameOptions,
    ) -> Result<FrameStats, Error> {
        let drawn = self.draw_frame(scene, camera, options);
        if drawn.is_err() {
            self.residency.forget();
        }
        drawn
    }

    fn draw_frame(
        &mut self,
        scene: &Scene,
        camera: &Camera,
        options: &FrameOptions,
    ) -> Result<FrameStats, Error> {
        let start = Instant::now();
        let mut stats = FrameStats { frame: self.frames, ..FrameStats::default() };
        let view = camera.view(options.size, scene.near(camera.eye))?;
        let chooser = match &options.frozen {
            Some(frozen) => frozen.view(options.size, scene.near(frozen.eye))?,
            None => view,
        };
        self.prepare(options)?;
        // Not by what is culled: a picture with and without occlusion culling is divided in the same way.
        let pays =
            if self.looks_at_depth(options.samples) { FrameOptions::LOOKS } else { FrameOptions::QUERIES };
        let options = &FrameOptions { queries: options.queries.or(Some(pays)), ..*options };
        let fit = self.fit_into_memory(scene, &chooser, &view, options)?;
        let asked = options.detail;
        let options = &FrameOptions { detail: fit.detail, ..*options };
        if let Detail::Gain(pixels) = options.detail {
            stats.gain = Some(pixels);
        }
        let plan = Plan::new(scene, &chooser, &view, options, &mut self.fitter, &mut stats)?;
        if let (Some(budget), Detail::Triangles(wanted)) = (&mut stats.budget, asked) {
            budget.wanted = wanted;
        }
        let mut clock = start;
        stats.milliseconds.cut += lap(&mut clock);

        let rows = self.upload_view(scene, &plan, &view, options)?;
        let sides = if options.two_sided { Sides::Both } else { Sides::Front };
        let frame = Frame { scene, view: &view, plan: &plan, options, rows, sides, paint: paint(options) };
        stats.milliseconds.upload += lap(&mut clock);
        let drawn = self.draw_in_rounds(&frame, &mut clock, &mut stats);
        self.plan = plan;
        drawn?;
        self.finish_stage(options, "drawing")?;
        stats.milliseconds.draw += lap(&mut clock);
        stats.memory = self.residency.stats(fit.coarser);
        stats.milliseconds.total = start.elapsed().as_secs_f64() * 1e3;
        self.gpu.check()?;
        self.frames = self.frames.wrapping_add(1);
        Ok(stats)
    }

    /// Reads the last frame back.
    ///
    /// # Errors
    /// What the driver says.
    pub fn image(&self, with_depth: bool) -> Result<Image, Error> {
        let Some(target) = &self.target else {
            return Ok(Image { width: 0, height: 0, rgba: Vec::new(), depth: None });
        };
        let [width, height] = target.size;
        let rgba = readback::picture(&self.gpu, target)?;
        let depth = if with_depth { readback::depth(&self.gpu, target)? } else { None };
        Ok(Image { width, height, rgba, depth })
    }

    /// The last frame's picture on the GPU.
    #[cfg(feature = "window")]
    pub(crate) fn picture(&self) -> Option<&wgpu::TextureView> {
        self.target.as_ref().map(|target| &target.picture_view)
    }

    /// Gives back all memory that the next frame fills anew.
    pub(crate) fn evict(&mut self) {
        self.residency.forget();
        self.target = None;
        self.queries = OcclusionQueries::default();
        self.depth_staging = None;
        self.outlines = Outlines::new();
        for pages in [&mut self.indices, &mut self.corners, &mut self.rows] {
            pages.clear();
        }
        self.forget_cuts();
    }

    /// Whether the memory for vertices can be halved.
    pub(crate) fn can_shrink(&self, scene: &Scene) -> bool {
        self.residency.half(scene).is_some()
    }

    /// Halves the memory for vertices, after which frames may be coarser.
    ///
    /// # Errors
    /// What the driver says.
    pub(crate) fn shrink(&mut self, scene: &Scene) -> Result<(), Error> {
        let Some(bytes) = self.residency.half(scene) else { return Ok(()) };
        // The old one goes first: both may not fit side by side.
        self.residency = Residency::Whole(Vec::new());
        self.residency = Residency::new(&self.gpu, scene, Some(bytes))?;
        Ok(())
    }

    /// Forgets what was kept of the scene's cuts; for when the scene's trees change.
    pub fn forget_cuts(&mut self) {
        self.whole.clear();
        self.whole_indices.restart(&self.gpu, 0);
    }

    /// Makes textures and pipelines for a frame's size and samples, where they are not there yet.
    fn prepare(&mut self, options: &FrameOptions) -> Result<(), Error> {
        let samples = if options.samples > 1 { 4 } else { 1 };
        if self.target.as_ref().is_none_or(|t| t.size != options.size || t.samples != samples) {
            // The old one goes first: two large targets may not fit side by side.
            self.target = None;
            self.target = Some(Target::new(&self.gpu, options.size, samples)?);
        }
        let kind = Kind { samples, shows_distance: options.color == ColorMode::Depth };
        if self.pipelines.as_ref().is_none_or(|p| p.kind != kind) {
            self.pipelines = Some(Pipelines::new(&self.gpu.device, &self.frame_layout, kind));
        }
        self.gpu.check()
    }

    /// Whether questions may be answered by a look at the depth: a program draws, one sample a pixel.
    fn looks_at_depth(&self, samples: u32) -> bool {
        self.software && samples == 1 && self.gpu.copies_depth()
    }

    /// Hands the view and the instances to the GPU. Returns where the instances lie.
    fn upload_view(
        &mut self,
        scene: &Scene,
        plan: &Plan,
        view: &View,
        options: &FrameOptions,
    ) -> Result<Place, Error> {
        let mut uniform = frame_uniform(view);
        if options.color == ColorMode::Depth {
            let span = distances::in_sight(scene, plan, view, options.two_sided);
            [uniform.depth[0], uniform.depth[1]] = depth_scale(span, view);
        }
        self.gpu.queue.write_buffer(&self.uniform, 0, bytemuck::bytes_of(&uniform));
        let rows: Vec<InstanceRow> = plan
            .placed
            .iter()
            .filter_map(|placed| scene.instances.get(placed.instance))
            .map(|instance| instance_row(scene, instance, view.eye))
            .collect();
        self.rows.restart(&self.gpu, size_of_val(rows.as_slice()) as u64);
        self.rows.push(&self.gpu, "the scene", &[bytemuck::cast_slice(&rows)])
    }

    /// Waits for the GPU where times are to be true.
    fn finish_stage(&self, options: &FrameOptions, what: &'static str) -> Result<(), Error> {
        if options.measure { self.gpu.wait(what) } else { Ok(()) }
    }
}

/// What a frame's options paint, if that takes unindexed triangles.
fn paint(options: &FrameOptions) -> Option<Paint> {
    let color = match options.color {
        ColorMode::Shaded | ColorMode::Depth => PaintColor::Model,
        ColorMode::Clusters => PaintColor::Cluster,
        ColorMode::Level => PaintColor::Level,
    };
    let plain = color == PaintColor::Model && !options.wireframe;
    (!plain).then_some(Paint { color, wireframe: options.wireframe })
}

/// Milliseconds since the last lap.
fn lap(clock: &mut Instant) -> f64 {
    let now = Instant::now();
    let time = now.duration_since(*clock).as_secs_f64() * 1e3;
    *clock = now;
    time
}

/// The view and its lights: they stand where the camera's picture has them, so form shows from every side.
fn frame_uniform(view: &View) -> FrameUniform {
    let direction = |right: f64, up: f64, back: f64| {
        let d = (right * view.right + up * view.up - back * view.forward).normalize_or(DVec3::Y);
        d.as_vec3().extend(0.0).to_array()
    };
    FrameUniform {
        clip_from_eye: view.clip_from_eye.as_mat4().to_cols_array_2d(),
        key: direction(-0.55, 0.70, 0.60),
        fill: direction(0.85, -0.05, 0.45),
        rim: direction(0.45, 0.55, -0.75),
        depth: [0.0, 0.0, (1.0 / view.near).min(f64::from(f32::MAX)) as f32, 0.0],
    }
}

/// What colours distances: the logarithm of the nearest in sight, in units of the near plane's, and one over its
/// difference to that of the farthest.
fn depth_scale([near, far]: [f64; 2], view: &View) -> [f32; 2] {
    let span = (far / near).log2().max(1e-3);
    [(near / view.near).log2() as f32, (1.0 / span) as f32]
}

/// An instance as the shaders read it: relative to the eye, so that 32 bits are enough.
fn instance_row(scene: &Scene, instance: &Instance, eye: DVec3) -> InstanceRow {
    let center = scene.models.get(instance.model).map_or(DVec3::ZERO, |model| model.center);
    let offset = instance.to_world(center) - eye;
    let matrix = glam::DMat3::from_quat(instance.rotation) * instance.scale;
    let row = |k: usize, offset: f64| matrix.row(k).extend(offset).as_vec4().to_array();
    InstanceRow {
        rows: [row(0, offset.x), row(1, offset.y), row(2, offset.z)],
        center: center.as_vec3().extend(instance.tint).to_array(),
    }
}

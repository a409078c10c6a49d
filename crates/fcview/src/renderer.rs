//! The renderer: a scene on a device, frame after frame.

mod census;
mod rounds;

pub use census::Census;

use crate::camera::{Camera, View};
use crate::frame::cluster_colors;
use crate::frame::cut::{CutId, Cuts};
use crate::frame::order;
use crate::frame::pieces::{self, Piece};
use crate::gpu::mesh::GpuMesh;
use crate::gpu::occlusion::OcclusionQueries;
use crate::gpu::pages::{Pages, Place};
use crate::gpu::pipelines::{self, ClusterVertex, FrameUniform, InstanceRow, Look, Pipelines, Sides};
use crate::gpu::readback;
use crate::gpu::target::Target;
use crate::options::{ColorMode, FrameOptions, Occlusion};
use crate::scene::{Instance, Scene};
use crate::stats::FrameStats;
use crate::{Error, Gpu, Image};
use glam::DVec3;
use std::time::Instant;

/// Draws frames of one scene.
pub struct Renderer {
    gpu: Gpu,
    meshes: Vec<GpuMesh>,
    frame_layout: wgpu::BindGroupLayout,
    uniform: wgpu::Buffer,
    bind_group: wgpu::BindGroup,
    pipelines: Option<Pipelines>,
    target: Option<Target>,
    indices: Pages,
    corners: Pages,
    rows: Pages,
    queries: OcclusionQueries,
    cuts: Cuts,
    pieces: Vec<Piece>,
    /// The pieces of the last frame that the queries removed.
    hidden: Vec<Piece>,
    frames: u32,
}

/// Where the cuts of a frame lie on the GPU.
struct Uploaded {
    /// Places of the shared cuts that are used, by their index.
    shared: Vec<(usize, Place)>,
    /// Places of the single cuts.
    own: Vec<Place>,
    rows: Place,
    /// Whether the triangles are unindexed.
    clusters: bool,
}

/// What a frame's passes share.
struct Drawing<'a> {
    scene: &'a Scene,
    view: &'a View,
    uploaded: &'a Uploaded,
    sides: Sides,
    /// Pieces of fewer triangles are drawn unasked.
    fewest: u32,
}

impl Renderer {
    /// Uploads a scene's models.
    ///
    /// # Errors
    /// [`Error::BufferSize`] if a model is larger than the adapter's buffers, or what the driver says.
    pub fn new(gpu: Gpu, scene: &Scene) -> Result<Renderer, Error> {
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
        let mut meshes = Vec::with_capacity(scene.models.len());
        for model in &scene.models {
            meshes.push(GpuMesh::upload(&gpu, &model.name, &model.tree)?);
            // Submitting now frees the staging memory before the next model needs its own.
            gpu.queue.submit([]);
        }
        gpu.check()?;
        Ok(Renderer {
            indices: Pages::new("indices", 4, wgpu::BufferUsages::INDEX),
            corners: Pages::new("corners", size_of::<ClusterVertex>() as u64, wgpu::BufferUsages::VERTEX),
            rows: Pages::new("instances", size_of::<InstanceRow>() as u64, wgpu::BufferUsages::VERTEX),
            gpu,
            meshes,
            frame_layout,
            uniform,
            bind_group,
            pipelines: None,
            target: None,
            queries: OcclusionQueries::default(),
            cuts: Cuts::default(),
            pieces: Vec::new(),
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
        let start = Instant::now();
        let mut stats = FrameStats { frame: self.frames, ..FrameStats::default() };
        let times = &mut stats.milliseconds;
        let view = camera.view(options.size, scene.near(camera.eye))?;
        let chooser = match &options.frozen {
            Some(frozen) => frozen.view(options.size, scene.near(frozen.eye))?,
            None => view,
        };
        self.prepare(options)?;

        self.cuts.make(scene, &chooser, options, &mut stats.counts)?;
        let mut clock = start;
        times.cut = lap(&mut clock);

        let uploaded = self.upload(scene, &view, options)?;
        self.finish_stage(options, "the upload")?;
        times.upload = lap(&mut clock);

        let largest = pieces::divide(scene, &view, &self.cuts, options.queries, &mut self.pieces);
        order::front_to_back(&mut self.pieces);
        stats.counts.batches = self.pieces.len() as u64;
        let sides = if options.two_sided { Sides::Both } else { Sides::Front };
        // Leftovers much smaller than the others are drawn sooner than asked about.
        let drawing = Drawing { scene, view: &view, uploaded: &uploaded, sides, fewest: largest / 4 };
        let pieces = std::mem::take(&mut self.pieces);
        self.hidden.clear();
        let drawn = match options.occlusion {
            Occlusion::Exact => self.draw_in_rounds(&drawing, &pieces, options, &mut clock, &mut stats),
            Occlusion::Off => self.draw_pieces(&drawing, &pieces, true, true),
        };
        self.pieces = pieces;
        stats.counts.triangles_drawn = drawn? / 3;
        self.finish_stage(options, "drawing")?;
        stats.milliseconds.draw += lap(&mut clock);
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
        self.target = None;
        self.queries = OcclusionQueries::default();
        for pages in [&mut self.indices, &mut self.corners, &mut self.rows] {
            pages.clear();
        }
        self.forget_cuts();
    }

    /// Forgets what was kept of the scene's cuts; for when the scene's trees change.
    pub fn forget_cuts(&mut self) {
        self.cuts.clear();
    }

    /// Makes textures and pipelines for a frame's size and samples, where they are not there yet.
    fn prepare(&mut self, options: &FrameOptions) -> Result<(), Error> {
        let samples = if options.samples > 1 { 4 } else { 1 };
        if self.target.as_ref().is_none_or(|t| t.size != options.size || t.samples != samples) {
            // The old one goes first: two large targets may not fit side by side.
            self.target = None;
            self.target = Some(Target::new(&self.gpu, options.size, samples)?);
        }
        if self.pipelines.as_ref().is_none_or(|p| p.samples != samples) {
            self.pipelines = Some(Pipelines::new(&self.gpu.device, &self.frame_layout, samples));
        }
        self.gpu.check()
    }

    /// Hands the cuts, the instances and the view to the GPU.
    fn upload(&mut self, scene: &Scene, view: &View, options: &FrameOptions) -> Result<Uploaded, Error> {
        let uniform = frame_uniform(view);
        self.gpu.queue.write_buffer(&self.uniform, 0, bytemuck::bytes_of(&uniform));
        let rows: Vec<InstanceRow> = self
            .cuts
            .placed
            .iter()
            .filter_map(|placed| scene.instances.get(placed.instance))
            .map(|instance| instance_row(scene, instance, view.eye))
            .collect();
        self.rows.restart(&self.gpu, size_of_val(rows.as_slice()) as u64);
        let rows = self.rows.push(&self.gpu, "the scene", bytemuck::cast_slice(&rows))?;

        let clusters = options.color == ColorMode::Clusters;
        let indices: usize = self.cuts.used().map(|(_, slot)| slot.extraction.indices.len()).sum();
        let stride = if clusters { size_of::<ClusterVertex>() } else { 4 };
        let pages = if clusters { &mut self.corners } else { &mut self.indices };
        pages.restart(&self.gpu, indices as u64 * stride as u64);
        let mut uploaded = Uploaded { shared: Vec::new(), own: Vec::new(), rows, clusters };
        for (id, slot) in self.cuts.used() {
            let place = match scene.models.get(slot.model) {
                Some(model) if clusters => {
                    let corners = cluster_colors::corners(&model.tree, slot);
                    pages.push(&self.gpu, &model.name, bytemuck::cast_slice(&corners))?
                }
                Some(model) => {
                    pages.push(&self.gpu, &model.name, bytemuck::cast_slice(&slot.extraction.indices))?
                }
                None => Place::default(),
            };
            match id {
                CutId::Shared(index) => uploaded.shared.push((index, place)),
                CutId::Own(_) => uploaded.own.push(place),
            }
        }
        Ok(uploaded)
    }

    /// Draws pieces in their order. Returns the number of indices drawn.
    fn draw_pieces(
        &self,
        drawing: &Drawing<'_>,
        pieces: &[Piece],
        first: bool,
        last: bool,
    ) -> Result<u64, Error> {
        let (Some(pipelines), Some(target)) = (&self.pipelines, &self.target) else { return Ok(0) };
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        let mut drawn = 0;
        {
            let mut pass = target.begin(&mut encoder, "surface", first, last);
            if first {
                pass.set_pipeline(&pipelines.background);
                pass.draw(0..3, 0..1);
            }
            pass.set_bind_group(0, &self.bind_group, &[]);
            let mut state = (None, usize::MAX, usize::MAX);
            let mut pieces = pieces.iter().peekable();
            while let Some(piece) = pieces.next() {
                // Neighbours in the cut that are neighbours in the order are one draw.
                let mut count = piece.index_count;
                while let Some(next) = pieces.next_if(|next| {
                    (next.placed, next.cut) == (piece.placed, piece.cut)
                        && next.first_index == piece.first_index + count
                }) {
                    count += next.index_count;
                }
                self.set_state(&mut pass, pipelines, drawing, piece, &mut state);
                let Some(place) = drawing.uploaded.place(piece.cut) else { continue };
                let start = place.first + piece.first_index;
                let row = drawing.uploaded.rows.first + piece.placed;
                if drawing.uploaded.clusters {
                    pass.draw(start..start + count, row..row + 1);
                } else {
                    pass.draw_indexed(start..start + count, 0, row..row + 1);
                }
                drawn += u64::from(count);
            }
        }
        self.gpu.queue.submit([encoder.finish()]);
        Ok(drawn)
    }

    /// Sets pipeline and buffers for a piece, where they differ from the last one's.
    fn set_state(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        pipelines: &Pipelines,
        drawing: &Drawing<'_>,
        piece: &Piece,
        state: &mut (Option<Look>, usize, usize),
    ) {
        let (Some(slot), Some(place)) = (self.cuts.slot(piece.cut), drawing.uploaded.place(piece.cut)) else {
            return;
        };
        let Some(mesh) = self.meshes.get(slot.model) else { return };
        let look = match (drawing.uploaded.clusters, mesh.has_normals) {
            (true, _) => Look::Clusters,
            (false, true) => Look::Smooth,
            (false, false) => Look::Flat,
        };
        if state.0 != Some(look) {
            if let Some(pipeline) = pipelines.surface(look, drawing.sides) {
                pass.set_pipeline(pipeline);
            }
            if let Some(rows) = self.rows.buffer(drawing.uploaded.rows.page) {
                pass.set_vertex_buffer(0, rows.slice(..));
            }
        }
        if look == Look::Clusters {
            if state.2 != place.page
                && let Some(corners) = self.corners.buffer(place.page)
            {
                pass.set_vertex_buffer(1, corners.slice(..));
            }
        } else {
            if state.1 != slot.model {
                pass.set_vertex_buffer(1, mesh.positions.slice(..));
                pass.set_vertex_buffer(2, mesh.normals.slice(..));
                pass.set_vertex_buffer(3, mesh.colors.slice(..));
            }
            if state.2 != place.page
                && let Some(indices) = self.indices.buffer(place.page)
            {
                pass.set_index_buffer(indices.slice(..), wgpu::IndexFormat::Uint32);
            }
        }
        *state = (Some(look), slot.model, place.page);
    }

    /// Waits for the GPU where times are to be true.
    fn finish_stage(&self, options: &FrameOptions, what: &'static str) -> Result<(), Error> {
        if options.measure { self.gpu.wait(what) } else { Ok(()) }
    }
}

impl Uploaded {
    fn place(&self, cut: CutId) -> Option<Place> {
        match cut {
            CutId::Own(index) => self.own.get(index).copied(),
            CutId::Shared(index) => self.shared.iter().find(|(i, _)| *i == index).map(|(_, place)| *place),
        }
    }
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
    }
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

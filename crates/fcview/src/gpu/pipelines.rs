//! The render pipelines and the layouts of what they read.

use super::target::{COLOR_FORMAT, DEPTH_FORMAT};
use bytemuck::{Pod, Zeroable};

/// The view and the lights, as `frame.wgsl` reads them.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub(crate) struct FrameUniform {
    pub(crate) clip_from_eye: [[f32; 4]; 4],
    pub(crate) key: [f32; 4],
    pub(crate) fill: [f32; 4],
    pub(crate) rim: [f32; 4],
    /// How distances are coloured: where the scale begins, and how much it grows; then one over the near plane's
    /// distance.
    pub(crate) depth: [f32; 4],
}

/// One placed copy of a model, as `frame.wgsl` reads it; 64 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct InstanceRow {
    /// Rows of the matrix from positions relative to the model's centre to eye space.
    pub(crate) rows: [[f32; 4]; 3],
    /// The model's centre, and the tint.
    pub(crate) center: [f32; 4],
}

/// A vertex of a model, as `surface.wgsl` reads it; 20 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct SurfaceVertex {
    pub(crate) position: [f32; 3],
    /// Octahedral coordinates; zero in models without normals.
    pub(crate) normal: [i16; 2],
    pub(crate) color: [u8; 4],
}

/// One corner of a triangle in the clusters mode, as `clusters.wgsl` reads it; 20 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct ClusterVertex {
    pub(crate) position: [f32; 3],
    pub(crate) color: [u8; 4],
    pub(crate) border: [u8; 4],
}

/// An end of a line over the picture, as `outlines.wgsl` reads it; 20 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct OutlineVertex {
    pub(crate) clip: [f32; 4],
    /// Linear, not sRGB.
    pub(crate) color: [u8; 4],
}

/// Which triangles the rasteriser keeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sides {
    /// Only triangles whose corners run counter-clockwise on screen.
    Front,
    /// Both windings.
    Both,
}

/// What is drawn: decides shader and vertex layout.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Look {
    /// Indexed triangles lit by stored normals.
    Smooth,
    /// Indexed triangles lit by the triangles' own normals.
    Flat,
    /// Unindexed triangles with colours and outlines of their own.
    Painted,
}

/// What all pipelines of a picture share.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Kind {
    /// Samples a pixel.
    pub(crate) samples: u32,
    /// Whether surfaces are coloured by their distance from the eye.
    pub(crate) shows_distance: bool,
}

/// All pipelines for one kind of picture.
pub(crate) struct Pipelines {
    pub(crate) kind: Kind,
    pub(crate) background: wgpu::RenderPipeline,
    pub(crate) bounding_polygon: wgpu::RenderPipeline,
    pub(crate) outlines: wgpu::RenderPipeline,
    surfaces: Vec<(Look, Sides, wgpu::RenderPipeline)>,
}

/// The layout of the bind group that holds the frame uniform.
pub(crate) fn frame_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("frame"),
        entries: &[wgpu::BindGroupLayoutEntry {
            binding: 0,
            visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
            ty: wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Uniform,
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        }],
    })
}

/// The attributes of an [`InstanceRow`].
pub(crate) const INSTANCE_ATTRIBUTES: [wgpu::VertexAttribute; 4] =
    wgpu::vertex_attr_array![0 => Float32x4, 1 => Float32x4, 2 => Float32x4, 3 => Float32x4];
const SURFACE_ATTRIBUTES: [wgpu::VertexAttribute; 3] =
    wgpu::vertex_attr_array![4 => Float32x3, 5 => Snorm16x2, 6 => Unorm8x4];
const CLUSTER_ATTRIBUTES: [wgpu::VertexAttribute; 3] =
    wgpu::vertex_attr_array![4 => Float32x3, 5 => Unorm8x4, 6 => Unorm8x4];
const OUTLINE_ATTRIBUTES: [wgpu::VertexAttribute; 2] =
    wgpu::vertex_attr_array![0 => Float32x4, 1 => Unorm8x4];
const POLYGON_ATTRIBUTES: [wgpu::VertexAttribute; 1] = wgpu::vertex_attr_array![0 => Float32x4];

/// A vertex buffer's layout.
pub(crate) fn layout<'a>(
    stride: usize,
    step_mode: wgpu::VertexStepMode,
    attributes: &'a [wgpu::VertexAttribute],
) -> Option<wgpu::VertexBufferLayout<'a>> {
    Some(wgpu::VertexBufferLayout { array_stride: stride as wgpu::BufferAddress, step_mode, attributes })
}

impl Pipelines {
    /// Compiles the pipelines.
    pub(crate) fn new(device: &wgpu::Device, frame: &wgpu::BindGroupLayout, kind: Kind) -> Pipelines {
        let with_frame = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("frame"),
            bind_group_layouts: &[Some(frame)],
            immediate_size: 0,
        });
        let bare = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("no bindings"),
            bind_group_layouts: &[],
            immediate_size: 0,
        });
        let common = include_str!("../shaders/frame.wgsl");
        let module = |label, source: String| {
            device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(label),
                source: wgpu::ShaderSource::Wgsl(source.into()),
            })
        };
        let surface = module("surface", [common, include_str!("../shaders/surface.wgsl")].concat());
        let clusters = module("clusters", [common, include_str!("../shaders/clusters.wgsl")].concat());
        let background = module("background", include_str!("../shaders/background.wgsl").to_owned());
        let polygon = module("bounding polygon", include_str!("../shaders/bounding_polygon.wgsl").to_owned());
        let outlines = module("outlines", include_str!("../shaders/outlines.wgsl").to_owned());

        let vertex = wgpu::VertexStepMode::Vertex;
        let instance_layout =
            layout(size_of::<InstanceRow>(), wgpu::VertexStepMode::Instance, &INSTANCE_ATTRIBUTES);
        let surface_layouts =
            [instance_layout.clone(), layout(size_of::<SurfaceVertex>(), vertex, &SURFACE_ATTRIBUTES)];
        let cluster_layouts =
            [instance_layout, layout(size_of::<ClusterVertex>(), vertex, &CLUSTER_ATTRIBUTES)];
        let polygon_layouts = [layout(16, vertex, &POLYGON_ATTRIBUTES)];

        let outline_layouts = [layout(size_of::<OutlineVertex>(), vertex, &OUTLINE_ATTRIBUTES)];

        let make = |recipe: Recipe<'_>| recipe.build(device, kind.samples);
        let mut surfaces = Vec::new();
        for look in [Look::Smooth, Look::Flat, Look::Painted] {
            for sides in [Sides::Front, Sides::Both] {
                let (module, buffers): (_, &[_]) = match look {
                    Look::Smooth | Look::Flat => (&surface, &surface_layouts),
                    Look::Painted => (&clusters, &cluster_layouts),
                };
                let distance = ("shows_distance", f64::from(u8::from(kind.shows_distance)));
                let constants: &[(&str, f64)] = match look {
                    Look::Smooth => &[distance, ("has_normals", 1.0)],
                    Look::Flat => &[distance, ("has_normals", 0.0)],
                    Look::Painted => &[distance],
                };
                let pipeline = make(Recipe {
                    label: "surface",
                    layout: &with_frame,
                    module,
                    buffers,
                    constants,
                    sides,
                    // Strictly nearer: of two surfaces at one depth the first drawn stays, so that leaving out
                    // hidden ones cannot change the picture.
                    depth_compare: wgpu::CompareFunction::Greater,
                    topology: TRIANGLES,
                    writes: Writes::ColorAndDepth,
                });
                surfaces.push((look, sides, pipeline));
            }
        }
        Pipelines {
            kind,
            background: make(Recipe {
                label: "background",
                layout: &bare,
                module: &background,
                buffers: &[],
                constants: &[],
                sides: Sides::Both,
                // It is as far as can be, so it shows where nothing else does.
                depth_compare: wgpu::CompareFunction::GreaterEqual,
                topology: TRIANGLES,
                writes: Writes::ColorAndDepth,
            }),
            bounding_polygon: make(Recipe {
                label: "bounding polygon",
                layout: &bare,
                module: &polygon,
                buffers: &polygon_layouts,
                constants: &[],
                sides: Sides::Both,
                // A polygon at the very depth that is there counts as visible: the safe side.
                depth_compare: wgpu::CompareFunction::GreaterEqual,
                topology: TRIANGLES,
                writes: Writes::Nothing,
            }),
            outlines: make(Recipe {
                label: "outlines",
                layout: &bare,
                module: &outlines,
                buffers: &outline_layouts,
                constants: &[],
                sides: Sides::Both,
                depth_compare: wgpu::CompareFunction::Always,
                topology: wgpu::PrimitiveTopology::LineList,
                writes: Writes::Color,
            }),
            surfaces,
        }
    }

    /// The pipeline for a look, if it exists (they all do).
    pub(crate) fn surface(&self, look: Look, sides: Sides) -> Option<&wgpu::RenderPipeline> {
        self.surfaces.iter().find(|(l, s, _)| (*l, *s) == (look, sides)).map(|(_, _, pipeline)| pipeline)
    }
}

/// What differs from one pipeline to another.
struct Recipe<'a> {
    label: &'static str,
    layout: &'a wgpu::PipelineLayout,
    module: &'a wgpu::ShaderModule,
    buffers: &'a [Option<wgpu::VertexBufferLayout<'a>>],
    constants: &'a [(&'a str, f64)],
    sides: Sides,
    depth_compare: wgpu::CompareFunction,
    topology: wgpu::PrimitiveTopology,
    writes: Writes,
}

const TRIANGLES: wgpu::PrimitiveTopology = wgpu::PrimitiveTopology::TriangleList;

/// What a pipeline leaves behind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Writes {
    Nothing,
    Color,
    ColorAndDepth,
}

impl Recipe<'_> {
    fn build(&self, device: &wgpu::Device, samples: u32) -> wgpu::RenderPipeline {
        let color = [Some(wgpu::ColorTargetState {
            format: COLOR_FORMAT,
            blend: None,
            write_mask: wgpu::ColorWrites::ALL,
        })];
        let options = wgpu::PipelineCompilationOptions { constants: self.constants, ..Default::default() };
        device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(self.label),
            layout: Some(self.layout),
            vertex: wgpu::VertexState {
                module: self.module,
                entry_point: Some("vertex"),
                compilation_options: options.clone(),
                buffers: self.buffers,
            },
            primitive: wgpu::PrimitiveState {
                topology: self.topology,
                cull_mode: (self.sides == Sides::Front).then_some(wgpu::Face::Back),
                ..Default::default()
            },
            depth_stencil: Some(wgpu::DepthStencilState {
                format: DEPTH_FORMAT,
                depth_write_enabled: Some(self.writes == Writes::ColorAndDepth),
                depth_compare: Some(self.depth_compare),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            }),
            multisample: wgpu::MultisampleState { count: samples, ..Default::default() },
            fragment: (self.writes != Writes::Nothing).then_some(wgpu::FragmentState {
                module: self.module,
                entry_point: Some("fragment"),
                compilation_options: options,
                targets: &color,
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}

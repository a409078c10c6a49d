//! The pipelines that count triangles: which show, which cover a pixel.

use super::pipelines::{INSTANCE_ATTRIBUTES, InstanceRow, Sides, layout};
use super::target::DEPTH_FORMAT;

/// The format of the picture of triangles' numbers.
pub(crate) const NUMBER_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Uint;

/// Bytes of a corner: its position, and its triangle's number.
pub(crate) const CORNER_BYTES: usize = 16;

const CORNER_ATTRIBUTES: [wgpu::VertexAttribute; 2] = wgpu::vertex_attr_array![4 => Float32x3, 5 => Uint32];

/// The pipelines and the layout of the words that one of them writes.
pub(crate) struct CensusPipelines {
    pub(crate) layout: wgpu::BindGroupLayout,
    /// Leaves the numbers of the triangles that show.
    pub(crate) shows: wgpu::RenderPipeline,
    /// Marks the triangles that cover a pixel's centre.
    pub(crate) covers: wgpu::RenderPipeline,
}

impl CensusPipelines {
    /// Compiles the pipelines.
    pub(crate) fn new(device: &wgpu::Device, frame: &wgpu::BindGroupLayout, sides: Sides) -> CensusPipelines {
        let words = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("census"),
            entries: &[wgpu::BindGroupLayoutEntry {
                binding: 0,
                visibility: wgpu::ShaderStages::FRAGMENT,
                ty: wgpu::BindingType::Buffer {
                    ty: wgpu::BufferBindingType::Storage { read_only: false },
                    has_dynamic_offset: false,
                    min_binding_size: None,
                },
                count: None,
            }],
        });
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("census"),
            bind_group_layouts: &[Some(frame), Some(&words)],
            immediate_size: 0,
        });
        let source = [include_str!("../shaders/frame.wgsl"), include_str!("../shaders/census.wgsl")].concat();
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("census"),
            source: wgpu::ShaderSource::Wgsl(source.into()),
        });
        let buffers = [
            layout(size_of::<InstanceRow>(), wgpu::VertexStepMode::Instance, &INSTANCE_ATTRIBUTES),
            layout(CORNER_BYTES, wgpu::VertexStepMode::Vertex, &CORNER_ATTRIBUTES),
        ];
        let number = [Some(NUMBER_FORMAT.into())];
        let make = |entry, targets, depth_compare, writes| {
            device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some(entry),
                layout: Some(&pipeline_layout),
                vertex: wgpu::VertexState {
                    module: &module,
                    entry_point: Some("vertex"),
                    compilation_options: Default::default(),
                    buffers: &buffers,
                },
                primitive: wgpu::PrimitiveState {
                    cull_mode: (sides == Sides::Front).then_some(wgpu::Face::Back),
                    ..Default::default()
                },
                depth_stencil: Some(wgpu::DepthStencilState {
                    format: DEPTH_FORMAT,
                    depth_write_enabled: Some(writes),
                    depth_compare: Some(depth_compare),
                    stencil: wgpu::StencilState::default(),
                    bias: wgpu::DepthBiasState::default(),
                }),
                multisample: wgpu::MultisampleState::default(),
                fragment: Some(wgpu::FragmentState {
                    module: &module,
                    entry_point: Some(entry),
                    compilation_options: Default::default(),
                    targets,
                }),
                multiview_mask: None,
                cache: None,
            })
        };
        CensusPipelines {
            shows: make("shows", &number, wgpu::CompareFunction::Greater, true),
            covers: make("covers", &[], wgpu::CompareFunction::Always, false),
            layout: words,
        }
    }
}

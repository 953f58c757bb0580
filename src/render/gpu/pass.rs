//! The pipelines: bindings that all passes over a light field share, and the step to the screen's sRGB.

use wgpu::{BindingType, ShaderStages, TextureSampleType, TextureViewDimension};

/// Linear pictures of the passes: full precision, so that they can be compared with their CPU twins.
pub const LINEAR_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;
/// What egui draws: sRGB-encoded values in a format that does not know about it.
pub const ENCODED_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// One picture kind over a light field.
#[derive(Debug)]
pub struct Pass {
    pub pipeline: wgpu::RenderPipeline,
}

/// Views and ray depths in two halves each, and the pass's uniform.
pub fn field_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let array = |binding| {
        let ty = BindingType::Texture {
            sample_type: TextureSampleType::Float { filterable: false },
            view_dimension: TextureViewDimension::D2Array,
            multisampled: false,
        };
        wgpu::BindGroupLayoutEntry { binding, visibility: ShaderStages::FRAGMENT, ty, count: None }
    };
    let uniform = wgpu::BindGroupLayoutEntry {
        binding: 4,
        visibility: ShaderStages::FRAGMENT,
        ty: BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    };
    let entries = [array(0), array(1), array(2), array(3), uniform];
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some("light field"), entries: &entries })
}

impl Pass {
    /// A pass from its shader, which `common.wgsl` is put before.
    pub fn new(device: &wgpu::Device, layout: &wgpu::BindGroupLayout, name: &str, source: &str) -> Self {
        let source = format!("{}\n{source}", include_str!("shaders/common.wgsl"));
        Self { pipeline: pipeline(device, layout, name, &source, LINEAR_FORMAT) }
    }
}

/// The step from linear light to what egui draws.
#[derive(Debug)]
pub struct Present {
    pub pipeline: wgpu::RenderPipeline,
    pub layout: wgpu::BindGroupLayout,
}

impl Present {
    /// Builds the step.
    pub fn new(device: &wgpu::Device) -> Self {
        let ty = BindingType::Texture {
            sample_type: TextureSampleType::Float { filterable: false },
            view_dimension: TextureViewDimension::D2,
            multisampled: false,
        };
        let entry = wgpu::BindGroupLayoutEntry { binding: 0, visibility: ShaderStages::FRAGMENT, ty, count: None };
        let layout = device
            .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some("present"), entries: &[entry] });
        let source = include_str!("shaders/present.wgsl");
        Self { pipeline: pipeline(device, &layout, "present", source, ENCODED_FORMAT), layout }
    }
}

fn pipeline(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    name: &str,
    source: &str,
    format: wgpu::TextureFormat,
) -> wgpu::RenderPipeline {
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(name),
        source: wgpu::ShaderSource::Wgsl(source.into()),
    });
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(name),
        bind_group_layouts: &[Some(layout)],
        immediate_size: 0,
    });
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(name),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("full_screen"),
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: Default::default(),
        depth_stencil: None,
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("main"),
            compilation_options: Default::default(),
            targets: &[Some(format.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}

/// Draws the full-screen triangle of a pipeline into a texture.
pub fn run(
    encoder: &mut wgpu::CommandEncoder,
    pipeline: &wgpu::RenderPipeline,
    bindings: &wgpu::BindGroup,
    target: &wgpu::TextureView,
) {
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: None,
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: target,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store },
        })],
        depth_stencil_attachment: None,
        timestamp_writes: None,
        occlusion_query_set: None,
        multiview_mask: None,
    });
    pass.set_pipeline(pipeline);
    pass.set_bind_group(0, bindings, &[]);
    pass.draw(0..3, 0..1);
}

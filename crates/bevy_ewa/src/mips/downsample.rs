//! A texture whose levels are generated, and the pipelines of `downsample.wesl`, which draw them.

use std::collections::HashMap;

use bevy::{
    prelude::*,
    render::{
        render_resource::{
            BindGroup, BindGroupEntry, BindGroupLayout, BindGroupLayoutEntries,
            BindGroupLayoutEntryBuilder, BindingResource, ColorTargetState, ColorWrites,
            CommandEncoder, LoadOp, MultisampleState, Operations, PipelineCompilationOptions,
            PipelineLayout, PipelineLayoutDescriptor, PrimitiveState, RawFragmentState,
            RawRenderPipelineDescriptor, RawVertexState, RenderPassColorAttachment,
            RenderPassDescriptor, RenderPipeline, ShaderModule, ShaderModuleDescriptor,
            ShaderSource, ShaderStages, StoreOp, Texture, TextureFormat, TextureSampleType,
            TextureView, TextureViewDescriptor, TextureViewDimension, binding_types::texture_2d,
        },
        renderer::RenderDevice,
    },
};

/// A texture, and how many of its levels are generated.
pub(crate) struct Levels<'a> {
    pub texture: &'a Texture,
    /// Format of the views: an sRGB format where the texels are sRGB.
    pub format: TextureFormat,
    /// Number of levels, the finest included.
    pub count: u32,
}

impl Levels<'_> {
    pub(super) fn view(&self, level: u32, layer: u32) -> TextureView {
        view(self.texture, Some(self.format), level, layer)
    }

    pub(super) fn size(&self, level: u32) -> [u32; 2] {
        [self.texture.width(), self.texture.height()].map(|side| (side >> level).max(1))
    }
}

/// The view of one level and layer.
pub(super) fn view(
    texture: &Texture,
    format: Option<TextureFormat>,
    level: u32,
    layer: u32,
) -> TextureView {
    texture.create_view(&TextureViewDescriptor {
        format,
        dimension: Some(TextureViewDimension::D2),
        base_mip_level: level,
        mip_level_count: Some(1),
        base_array_layer: layer,
        array_layer_count: Some(1),
        ..default()
    })
}

/// What a pipeline draws.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Draw {
    Copy {
        to: TextureFormat,
    },
    Downsample {
        to: TextureFormat,
        mean: TextureFormat,
        content: u32,
    },
    ScaleAlpha {
        to: TextureFormat,
    },
}

/// The pipelines that draw, which are created as they are needed.
pub(super) struct DrawPipelines {
    shader: ShaderModule,
    layout: BindGroupLayout,
    pipeline_layout: PipelineLayout,
    pipelines: HashMap<Draw, RenderPipeline>,
}

pub(super) fn shader(device: &RenderDevice, label: &str, text: &str) -> ShaderModule {
    device.create_and_validate_shader_module(ShaderModuleDescriptor {
        label: Some(label),
        source: ShaderSource::Wgsl(text.into()),
    })
}

pub(super) fn pipeline_layout(device: &RenderDevice, layout: &BindGroupLayout) -> PipelineLayout {
    device.create_pipeline_layout(&PipelineLayoutDescriptor {
        label: Some("bevy_ewa_mips"),
        bind_group_layouts: &[Some(layout)],
        immediate_size: 0,
    })
}

/// A binding of a level of any format that holds floats.
pub(super) fn source() -> BindGroupLayoutEntryBuilder {
    texture_2d(TextureSampleType::Float { filterable: false })
}

impl DrawPipelines {
    pub(super) fn new(device: &RenderDevice) -> Self {
        let layout = device.create_bind_group_layout(
            "bevy_ewa_mips_draw",
            &BindGroupLayoutEntries::single(ShaderStages::FRAGMENT, source()),
        );
        Self {
            shader: shader(
                device,
                "bevy_ewa/downsample",
                include_str!("downsample.wesl"),
            ),
            pipeline_layout: pipeline_layout(device, &layout),
            layout,
            pipelines: HashMap::new(),
        }
    }

    pub(super) fn bind_group(&self, device: &RenderDevice, source: &TextureView) -> BindGroup {
        device.create_bind_group(
            "bevy_ewa_mips",
            &self.layout,
            &[BindGroupEntry {
                binding: 0,
                resource: BindingResource::TextureView(source),
            }],
        )
    }

    /// The pipeline that draws so, with a fragment shader of another module where one is given.
    pub(super) fn pipeline(
        &mut self,
        device: &RenderDevice,
        draw: Draw,
        fragment: Option<(&ShaderModule, &PipelineLayout)>,
    ) -> RenderPipeline {
        let vertex = &self.shader;
        let (module, pipeline_layout) = fragment.unwrap_or((vertex, &self.pipeline_layout));
        let pipeline = self.pipelines.entry(draw).or_insert_with(|| {
            let (entry_point, formats, content) = match draw {
                Draw::Copy { to } => ("copy", vec![to], 0),
                Draw::Downsample { to, mean, content } => ("downsample", vec![to, mean], content),
                Draw::ScaleAlpha { to } => ("scale_alpha", vec![to], 0),
            };
            let targets: Vec<_> = formats
                .into_iter()
                .map(|format| {
                    Some(ColorTargetState {
                        format,
                        blend: None,
                        write_mask: ColorWrites::ALL,
                    })
                })
                .collect();
            let constants = [("CONTENT", f64::from(content))];
            let constants: &[(&str, f64)] = if entry_point == "downsample" {
                &constants
            } else {
                &[]
            };
            device.create_render_pipeline(&RawRenderPipelineDescriptor {
                label: Some("bevy_ewa_mips"),
                layout: Some(pipeline_layout),
                vertex: RawVertexState {
                    module: vertex,
                    entry_point: Some("whole_level"),
                    compilation_options: PipelineCompilationOptions::default(),
                    buffers: &[],
                },
                primitive: PrimitiveState::default(),
                depth_stencil: None,
                multisample: MultisampleState::default(),
                fragment: Some(RawFragmentState {
                    module,
                    entry_point: Some(entry_point),
                    compilation_options: PipelineCompilationOptions {
                        constants,
                        ..default()
                    },
                    targets: &targets,
                }),
                multiview_mask: None,
                cache: None,
            })
        });
        pipeline.clone()
    }
}

/// Draws a level by a pipeline.
pub(super) fn draw_level(
    encoder: &mut CommandEncoder,
    pipeline: &RenderPipeline,
    bind_group: &BindGroup,
    targets: &[&TextureView],
) {
    let attachments: Vec<_> = targets
        .iter()
        .map(|view| {
            Some(RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target: None,
                ops: Operations {
                    load: LoadOp::Clear(default()),
                    store: StoreOp::Store,
                },
            })
        })
        .collect();
    let mut pass = encoder.begin_render_pass(&RenderPassDescriptor {
        label: Some("bevy_ewa_mips"),
        color_attachments: &attachments,
        ..default()
    });
    pass.set_pipeline(pipeline);
    pass.set_bind_group(0, &**bind_group, &[]);
    pass.draw(0..3, 0..1);
}

//! The mip levels of a texture on the GPU, from its finest level.
//!
//! Each level is drawn from the means of the finer one, which are kept in floats until all levels are there, so that
//! rounding does not add up. The pipelines are created when the first texture needs them, and at once: a texture is
//! never seen without its levels.

use std::collections::HashMap;

use bevy::{
    prelude::*,
    render::{
        render_resource::{
            BindGroup, BindGroupEntry, BindGroupLayout, BindGroupLayoutEntries,
            BindGroupLayoutEntryBuilder, BindingResource, Buffer, BufferInitDescriptor,
            BufferUsages, ColorTargetState, ColorWrites, CommandEncoder, ComputePassDescriptor,
            ComputePipeline, Extent3d, LoadOp, MultisampleState, Operations,
            PipelineCompilationOptions, PipelineLayout, PipelineLayoutDescriptor, PrimitiveState,
            RawComputePipelineDescriptor, RawFragmentState, RawRenderPipelineDescriptor,
            RawVertexState, RenderPassColorAttachment, RenderPassDescriptor, RenderPipeline,
            ShaderModule, ShaderModuleDescriptor, ShaderSource, ShaderStages, ShaderType, StoreOp,
            Texture, TextureDescriptor, TextureDimension, TextureFormat, TextureSampleType,
            TextureUsages, TextureView, TextureViewDescriptor, TextureViewDimension,
            binding_types::{storage_buffer_sized, texture_2d, uniform_buffer_sized},
            encase::UniformBuffer,
        },
        renderer::RenderDevice,
    },
};

use super::{MipContent, coverage::LOG_SCALES};

/// Rounds in which the range of a mask's scales is narrowed, each to a 31st.
const ROUNDS: u32 = 3;
/// Size of `Coverage` in `coverage.wesl`, in bytes.
const COVERAGE_BYTES: usize = 4 * (4 + 32);
const COVERAGE_WORKGROUP: u32 = 8;

/// The pipelines that generate mip levels, which are created when a texture needs them first.
#[derive(Resource, Default)]
pub(crate) struct MipGenerator {
    drawing: Option<DrawPipelines>,
    coverage: Option<CoveragePipelines>,
}

struct DrawPipelines {
    shader: ShaderModule,
    layout: BindGroupLayout,
    pipeline_layout: PipelineLayout,
    pipelines: HashMap<Draw, RenderPipeline>,
}

struct CoveragePipelines {
    shader: ShaderModule,
    layout: BindGroupLayout,
    pipeline_layout: PipelineLayout,
    count: ComputePipeline,
    choose: ComputePipeline,
}

/// What a pipeline draws.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Draw {
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

/// A step of finding the scale of a level: `Step` in `coverage.wesl`.
#[derive(Clone, Copy, Default, ShaderType)]
struct Step {
    level: u32,
    positions: u32,
    samples: u32,
    finest_samples: u32,
    cutoff: f32,
    is_last: u32,
}

/// A texture, and how many of its levels are generated.
pub(crate) struct Levels<'a> {
    pub texture: &'a Texture,
    /// Format of the views: an sRGB format where the texels are sRGB.
    pub format: TextureFormat,
    /// Number of levels, the finest included.
    pub count: u32,
}

impl Levels<'_> {
    fn view(&self, level: u32, layer: u32) -> TextureView {
        view(self.texture, Some(self.format), level, layer)
    }

    fn size(&self, level: u32) -> [u32; 2] {
        [self.texture.width(), self.texture.height()].map(|side| (side >> level).max(1))
    }
}

fn view(texture: &Texture, format: Option<TextureFormat>, level: u32, layer: u32) -> TextureView {
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

fn shader(device: &RenderDevice, label: &str, text: &str) -> ShaderModule {
    device.create_and_validate_shader_module(ShaderModuleDescriptor {
        label: Some(label),
        source: ShaderSource::Wgsl(text.into()),
    })
}

fn pipeline_layout(device: &RenderDevice, layout: &BindGroupLayout) -> PipelineLayout {
    device.create_pipeline_layout(&PipelineLayoutDescriptor {
        label: Some("bevy_ewa_mips"),
        bind_group_layouts: &[Some(layout)],
        immediate_size: 0,
    })
}

fn source() -> BindGroupLayoutEntryBuilder {
    texture_2d(TextureSampleType::Float { filterable: false })
}

impl DrawPipelines {
    fn new(device: &RenderDevice) -> Self {
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
}

impl CoveragePipelines {
    /// `None` where the device has no compute shaders: masks are averaged as other transparent colours there.
    fn new(device: &RenderDevice) -> Option<Self> {
        let limits = device.limits();
        let has_compute = limits.max_storage_buffers_per_shader_stage > 0
            && limits.max_compute_invocations_per_workgroup >= COVERAGE_WORKGROUP.pow(2);
        if !has_compute {
            return None;
        }
        let shader = shader(device, "bevy_ewa/coverage", include_str!("coverage.wesl"));
        let layout = device.create_bind_group_layout(
            "bevy_ewa_mips_coverage",
            &BindGroupLayoutEntries::sequential(
                ShaderStages::FRAGMENT | ShaderStages::COMPUTE,
                (
                    source(),
                    storage_buffer_sized(false, None),
                    uniform_buffer_sized(false, None),
                ),
            ),
        );
        let pipeline_layout = pipeline_layout(device, &layout);
        let compute = |entry_point| {
            device.create_compute_pipeline(&RawComputePipelineDescriptor {
                label: Some(entry_point),
                layout: Some(&pipeline_layout),
                module: &shader,
                entry_point: Some(entry_point),
                compilation_options: PipelineCompilationOptions::default(),
                cache: None,
            })
        };
        Some(Self {
            count: compute("count"),
            choose: compute("choose"),
            layout,
            pipeline_layout,
            shader,
        })
    }

    fn bind_group(
        &self,
        device: &RenderDevice,
        source: &TextureView,
        coverages: &Buffer,
        step: Step,
    ) -> BindGroup {
        let mut bytes = UniformBuffer::new(Vec::new());
        bytes.write(&step).expect("a vector takes all bytes");
        let step = device.create_buffer_with_data(&BufferInitDescriptor {
            label: Some("bevy_ewa_mips_step"),
            contents: &bytes.into_inner(),
            usage: BufferUsages::UNIFORM,
        });
        device.create_bind_group(
            "bevy_ewa_mips_coverage",
            &self.layout,
            &[
                BindGroupEntry {
                    binding: 0,
                    resource: BindingResource::TextureView(source),
                },
                BindGroupEntry {
                    binding: 1,
                    resource: coverages.as_entire_binding(),
                },
                BindGroupEntry {
                    binding: 2,
                    resource: step.as_entire_binding(),
                },
            ],
        )
    }
}

impl MipGenerator {
    /// Generates all levels of a texture but the finest one, from that.
    pub(crate) fn generate(
        &mut self,
        device: &RenderDevice,
        encoder: &mut CommandEncoder,
        levels: &Levels,
        content: MipContent,
    ) {
        // What 8 bits hold is exact in half floats to a quarter of a step.
        let channels = levels.format.components();
        let mean = if levels.format.block_copy_size(None) == Some(u32::from(channels)) {
            TextureFormat::Rgba16Float
        } else {
            TextureFormat::Rgba32Float
        };
        let draw = Draw::Downsample {
            to: levels.format,
            mean,
            content: match content {
                MipContent::Normals if channels > 2 => 1,
                MipContent::Values | MipContent::Normals => 0,
                MipContent::Transparent | MipContent::Mask { .. } => 2,
            },
        };
        let [width, height] = levels.size(1);
        let means = device.create_texture(&TextureDescriptor {
            label: Some("bevy_ewa_mips_means"),
            size: Extent3d {
                width,
                height,
                depth_or_array_layers: 1,
            },
            mip_level_count: levels.count - 1,
            sample_count: 1,
            dimension: TextureDimension::D2,
            format: mean,
            usage: TextureUsages::TEXTURE_BINDING | TextureUsages::RENDER_ATTACHMENT,
            view_formats: &[],
        });
        let means: Vec<_> = (0..levels.count - 1)
            .map(|level| view(&means, None, level, 0))
            .collect();
        for layer in 0..levels.texture.depth_or_array_layers() {
            let finest = levels.view(0, layer);
            for level in 1..levels.count {
                let source = match level {
                    1 => &finest,
                    _ => &means[level as usize - 2],
                };
                let to = levels.view(level, layer);
                self.draw(
                    device,
                    encoder,
                    draw,
                    source,
                    &[&to, &means[level as usize - 1]],
                );
            }
            if let MipContent::Mask { cutoff } = content
                && channels == 4
            {
                self.keep_coverage(device, encoder, levels, layer, cutoff, &finest, &means);
            }
        }
    }

    /// Copies the finest level of a texture to another one of the same size.
    pub(crate) fn copy(
        &mut self,
        device: &RenderDevice,
        encoder: &mut CommandEncoder,
        from: &Levels,
        to: &Levels,
    ) {
        if from.texture.usage().contains(TextureUsages::COPY_SRC) {
            let (from, to) = (from.texture, to.texture);
            encoder.copy_texture_to_texture(from.as_image_copy(), to.as_image_copy(), from.size());
            return;
        }
        for layer in 0..from.texture.depth_or_array_layers() {
            let draw = Draw::Copy { to: to.format };
            let (from, to) = (from.view(0, layer), to.view(0, layer));
            self.draw(device, encoder, draw, &from, &[&to]);
        }
    }

    /// Scales the alpha of all levels of a mask but the finest one.
    fn keep_coverage(
        &mut self,
        device: &RenderDevice,
        encoder: &mut CommandEncoder,
        levels: &Levels,
        layer: u32,
        cutoff: f32,
        finest: &TextureView,
        means: &[TextureView],
    ) {
        if self.coverage.is_none() {
            self.coverage = CoveragePipelines::new(device);
        }
        let draw = Draw::ScaleAlpha { to: levels.format };
        let Some((pipeline, _)) = self.pipeline(device, draw) else {
            return;
        };
        let Some(coverage) = &self.coverage else {
            return;
        };
        let mut contents = vec![0_u8; COVERAGE_BYTES * levels.count as usize];
        for level in contents.chunks_exact_mut(COVERAGE_BYTES).skip(1) {
            level[..4].copy_from_slice(&LOG_SCALES[0].to_le_bytes());
            level[4..8].copy_from_slice(&LOG_SCALES[1].to_le_bytes());
        }
        let coverages = device.create_buffer_with_data(&BufferInitDescriptor {
            label: Some("bevy_ewa_mips_coverages"),
            contents: &contents,
            usage: BufferUsages::STORAGE,
        });
        let sampled = |level: u32| {
            let size = levels.size(level);
            let positions = match size[0].max(size[1]) {
                512.. => 2,
                128.. => 4,
                32.. => 8,
                _ => 16,
            };
            (size, positions, size[0] * size[1] * positions * positions)
        };
        let step = |level, is_last| {
            let (_, positions, samples) = sampled(level);
            Step {
                level,
                positions,
                samples,
                finest_samples: sampled(0).2,
                cutoff,
                is_last: u32::from(is_last),
            }
        };
        let count =
            |encoder: &mut CommandEncoder, bind_group: &BindGroup, size: [u32; 2], chooses| {
                let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor {
                    label: Some("bevy_ewa_mips_coverage"),
                    timestamp_writes: None,
                });
                pass.set_bind_group(0, &**bind_group, &[]);
                pass.set_pipeline(&coverage.count);
                let [x, y] = size.map(|side| side.div_ceil(COVERAGE_WORKGROUP));
                pass.dispatch_workgroups(x, y, 1);
                if chooses {
                    pass.set_pipeline(&coverage.choose);
                    pass.dispatch_workgroups(1, 1, 1);
                }
            };
        let of_finest = coverage.bind_group(device, finest, &coverages, step(0, false));
        count(encoder, &of_finest, levels.size(0), false);
        for level in 1..levels.count {
            let means = &means[level as usize - 1];
            let narrowing = coverage.bind_group(device, means, &coverages, step(level, false));
            let last = coverage.bind_group(device, means, &coverages, step(level, true));
            for round in 1..=ROUNDS {
                let bind_group = if round == ROUNDS { &last } else { &narrowing };
                count(encoder, bind_group, levels.size(level), true);
            }
            draw_level(encoder, &pipeline, &last, &[&levels.view(level, layer)]);
        }
    }

    fn draw(
        &mut self,
        device: &RenderDevice,
        encoder: &mut CommandEncoder,
        draw: Draw,
        source: &TextureView,
        targets: &[&TextureView],
    ) {
        let Some((pipeline, layout)) = self.pipeline(device, draw) else {
            return;
        };
        let bind_group = device.create_bind_group(
            "bevy_ewa_mips",
            &layout,
            &[BindGroupEntry {
                binding: 0,
                resource: BindingResource::TextureView(source),
            }],
        );
        draw_level(encoder, &pipeline, &bind_group, targets);
    }

    /// The pipeline that draws so, with the layout of its bind group; `None` where the device cannot.
    fn pipeline(
        &mut self,
        device: &RenderDevice,
        draw: Draw,
    ) -> Option<(RenderPipeline, BindGroupLayout)> {
        let drawing = self
            .drawing
            .get_or_insert_with(|| DrawPipelines::new(device));
        let vertex = &drawing.shader;
        let (module, layout, pipeline_layout) = match draw {
            Draw::ScaleAlpha { .. } => {
                let coverage = self.coverage.as_ref()?;
                (
                    &coverage.shader,
                    &coverage.layout,
                    &coverage.pipeline_layout,
                )
            }
            Draw::Copy { .. } | Draw::Downsample { .. } => {
                (vertex, &drawing.layout, &drawing.pipeline_layout)
            }
        };
        let pipeline = drawing.pipelines.entry(draw).or_insert_with(|| {
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
        Some((pipeline.clone(), layout.clone()))
    }
}

fn draw_level(
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

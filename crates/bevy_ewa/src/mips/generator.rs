//! Which images get mip levels and why others do not, and the levels of a texture on the GPU, from its finest one.
//!
//! Each level is drawn from the means of the finer one, which are kept in floats until all levels are there, so that
//! rounding does not add up. The pipelines are created when the first texture needs them, and at once: a texture is
//! never seen without its levels.
//!
//! Levels are drawn by the pipelines of `downsample.wesl`. The passes of `coverage.wesl` find by how much the alpha of a
//! mask's levels is scaled.

use std::collections::HashMap;

use bevy::{
    prelude::*,
    render::{
        render_resource::{
            BindGroup, BindGroupEntries, BindGroupLayout, BindGroupLayoutEntries,
            BindGroupLayoutEntryBuilder, Buffer, BufferInitDescriptor, BufferUsages,
            CommandEncoder, ComputePassDescriptor, ComputePipeline, Extent3d, MultisampleState,
            Operations, PipelineCompilationOptions, PipelineLayout, PipelineLayoutDescriptor,
            PrimitiveState, RawComputePipelineDescriptor, RawFragmentState,
            RawRenderPipelineDescriptor, RawVertexState, RenderPassColorAttachment,
            RenderPassDescriptor, RenderPipeline, ShaderModule, ShaderModuleDescriptor,
            ShaderSource, ShaderStages, ShaderType, Texture, TextureDescriptor, TextureDimension,
            TextureFormat, TextureSampleType, TextureUsages, TextureView, TextureViewDescriptor,
            TextureViewDimension,
            binding_types::{storage_buffer_sized, texture_2d, uniform_buffer_sized},
            encase::UniformBuffer,
        },
        renderer::{RenderAdapter, RenderDevice},
    },
};
use bevy_frugal_hooks::format_features;

use super::chain::{LOG_SCALES, MipContent};

/// Why a texture has no generated mip levels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Reflect)]
#[reflect(Debug, PartialEq, Hash)]
#[non_exhaustive]
pub enum NoMips {
    /// The image is not loaded yet, or was removed.
    NotLoaded,
    /// The app excluded the image, or limited its levels to one.
    Excluded,
    /// The image has a single texel.
    OneTexel,
    /// The sampler chooses the nearest texel, as for pixel art. [`EwaImage::use_nearest`] changes this.
    ///
    /// [`EwaImage::use_nearest`]: crate::EwaImage::use_nearest
    NearestSampler,
    /// Cameras draw to the image or shaders write it, and the app did not ask for levels after each draw.
    /// [`EwaImage::after_draws`] does so.
    ///
    /// [`EwaImage::after_draws`]: crate::EwaImage::after_draws
    WrittenOnGpu,
    /// The image has one or three dimensions, or several samples a texel.
    Dimension,
    /// The device cannot draw to the format: compressed formats, signed normalized formats and RGB9E5, on some devices
    /// 16-bit normalized formats. Such images need levels of their own, which tools of these formats write.
    Format(#[reflect(ignore, default = "unknown_format")] TextureFormat),
    /// Nothing renders.
    NoRenderer,
}

fn unknown_format() -> TextureFormat {
    TextureFormat::Rgba8Unorm
}

/// The device that decides for which formats levels can be generated.
pub(crate) struct MipSupport<'a> {
    pub device: &'a RenderDevice,
    pub adapter: &'a RenderAdapter,
}

impl MipSupport<'_> {
    fn can_draw_to(&self, format: TextureFormat) -> bool {
        let sample_type = format.sample_type(None, Some(self.device.features()));
        let is_float = matches!(sample_type, Some(TextureSampleType::Float { .. }));
        let usages = TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING;
        let features = format_features(format, self.adapter, self.device);
        is_float && features.allowed_usages.contains(usages)
    }

    /// The number of levels that a texture without levels of its own could have.
    pub(crate) fn levels(&self, descriptor: &TextureDescriptor) -> Result<u32, NoMips> {
        if descriptor.dimension != TextureDimension::D2 || descriptor.sample_count != 1 {
            return Err(NoMips::Dimension);
        }
        if !self.can_draw_to(descriptor.format) {
            return Err(NoMips::Format(descriptor.format));
        }
        match descriptor.size.max_mips(descriptor.dimension) {
            1 => Err(NoMips::OneTexel),
            levels => Ok(levels),
        }
    }
}

/// Whether cameras draw to a texture, or shaders write it.
pub(crate) fn is_written_on_gpu(descriptor: &TextureDescriptor) -> bool {
    let written = TextureUsages::RENDER_ATTACHMENT | TextureUsages::STORAGE_BINDING;
    descriptor.usage.intersects(written)
}

/// The pipelines that generate mip levels, which are created when a texture needs them first.
#[derive(Resource, Default)]
pub(crate) struct MipGenerator {
    drawing: Option<DrawPipelines>,
    coverage: Option<CoveragePipelines>,
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
        // What 8 bits hold is exact in half floats to a quarter of a step, unless short normals are made longer.
        let channels = levels.format.components();
        let has_bytes = levels.format.block_copy_size(None) == Some(u32::from(channels));
        let mean = if has_bytes && content != MipContent::Normals {
            TextureFormat::Rgba16Float
        } else {
            TextureFormat::Rgba32Float
        };
        let draw = Draw {
            fragment: "downsample",
            targets: [Some(levels.format), Some(mean)],
            content: Some(match content {
                MipContent::Normals if channels > 2 => 1,
                MipContent::Values | MipContent::Normals => 0,
                MipContent::Transparent | MipContent::Mask { .. } => 2,
            }),
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
                let mask = MaskLevels {
                    levels,
                    layer,
                    cutoff,
                    finest: &finest,
                    means: &means,
                };
                self.keep_coverage(device, encoder, &mask);
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
            let draw = Draw::to("copy", to.format);
            let (from, to) = (from.view(0, layer), to.view(0, layer));
            self.draw(device, encoder, draw, &from, &[&to]);
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
        let drawing = self
            .drawing
            .get_or_insert_with(|| DrawPipelines::new(device));
        let bind_group = drawing.bind_group(device, source);
        let pipeline = drawing.pipeline(device, draw, None);
        draw_level(encoder, &pipeline, &bind_group, targets);
    }

    /// Scales the alpha of all levels of a mask but the finest one, where the device has compute shaders.
    fn keep_coverage(
        &mut self,
        device: &RenderDevice,
        encoder: &mut CommandEncoder,
        mask: &MaskLevels,
    ) {
        if self.coverage.is_none() {
            self.coverage = CoveragePipelines::new(device);
        }
        let (Some(drawing), Some(coverage)) = (&mut self.drawing, &self.coverage) else {
            return;
        };
        let draw = Draw::to("scale_alpha", mask.levels.format);
        let fragment = (&coverage.shader, &coverage.pipeline_layout);
        let pipeline = drawing.pipeline(device, draw, Some(fragment));
        coverage.scale_alpha(device, encoder, mask, &pipeline);
    }
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

/// The view of one level and layer.
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

/// The key of a pipeline.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Draw {
    /// Entry point of the fragment shader.
    fragment: &'static str,
    targets: [Option<TextureFormat>; 2],
    /// `CONTENT` in `downsample.wesl`.
    content: Option<u32>,
}

impl Draw {
    fn to(fragment: &'static str, target: TextureFormat) -> Self {
        Self {
            fragment,
            targets: [Some(target), None],
            content: None,
        }
    }
}

/// The pipelines that draw, which are created as they are needed.
struct DrawPipelines {
    shader: ShaderModule,
    layout: BindGroupLayout,
    pipeline_layout: PipelineLayout,
    pipelines: HashMap<Draw, RenderPipeline>,
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

/// A binding of a level of any format that holds floats.
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

    fn bind_group(&self, device: &RenderDevice, source: &TextureView) -> BindGroup {
        device.create_bind_group(
            "bevy_ewa_mips",
            &self.layout,
            &BindGroupEntries::single(source),
        )
    }

    /// The pipeline that draws so, with a fragment shader of another module where one is given.
    fn pipeline(
        &mut self,
        device: &RenderDevice,
        draw: Draw,
        fragment: Option<(&ShaderModule, &PipelineLayout)>,
    ) -> RenderPipeline {
        let vertex = &self.shader;
        let (module, pipeline_layout) = fragment.unwrap_or((vertex, &self.pipeline_layout));
        let pipeline = self.pipelines.entry(draw).or_insert_with(|| {
            let formats = draw.targets.into_iter().flatten();
            let targets: Vec<_> = formats.map(|format| Some(format.into())).collect();
            let content = draw.content.map(|content| ("CONTENT", content.into()));
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
                    entry_point: Some(draw.fragment),
                    compilation_options: PipelineCompilationOptions {
                        constants: content.as_slice(),
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
                ops: Operations::default(),
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

/// Rounds in which the range of a mask's scales is narrowed, each to a 31st.
const ROUNDS: u32 = 3;
/// Size of `Coverage` in `coverage.wesl`, in bytes.
const COVERAGE_BYTES: usize = 4 * (4 + 32);
const COVERAGE_WORKGROUP: u32 = 8;

/// The pipelines of `coverage.wesl`.
struct CoveragePipelines {
    shader: ShaderModule,
    layout: BindGroupLayout,
    pipeline_layout: PipelineLayout,
    count: ComputePipeline,
    choose: ComputePipeline,
}

/// The levels of a mask whose means are there.
struct MaskLevels<'a> {
    levels: &'a Levels<'a>,
    layer: u32,
    /// The least alpha that is visible.
    cutoff: f32,
    /// View of the finest level.
    finest: &'a TextureView,
    /// Views of the means in the others.
    means: &'a [TextureView],
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
            &BindGroupEntries::sequential((
                source,
                coverages.as_entire_binding(),
                step.as_entire_binding(),
            )),
        )
    }

    /// Scales the alpha of all levels but the finest one, by the pipeline that draws the scaled levels.
    fn scale_alpha(
        &self,
        device: &RenderDevice,
        encoder: &mut CommandEncoder,
        mask: &MaskLevels,
        pipeline: &RenderPipeline,
    ) {
        let mut contents = vec![0_u8; COVERAGE_BYTES * mask.levels.count as usize];
        for level in contents.chunks_exact_mut(COVERAGE_BYTES).skip(1) {
            level[..4].copy_from_slice(&LOG_SCALES[0].to_le_bytes());
            level[4..8].copy_from_slice(&LOG_SCALES[1].to_le_bytes());
        }
        let coverages = device.create_buffer_with_data(&BufferInitDescriptor {
            label: Some("bevy_ewa_mips_coverages"),
            contents: &contents,
            usage: BufferUsages::STORAGE,
        });
        let samples_of = |level: u32| {
            let size = mask.levels.size(level);
            let positions = match size[0].max(size[1]) {
                512.. => 2,
                128.. => 4,
                32.. => 8,
                _ => 16,
            };
            (size, positions, size[0] * size[1] * positions * positions)
        };
        let step = |level, is_last| {
            let (_, positions, samples) = samples_of(level);
            Step {
                level,
                positions,
                samples,
                finest_samples: samples_of(0).2,
                cutoff: mask.cutoff,
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
                pass.set_pipeline(&self.count);
                let [x, y] = size.map(|side| side.div_ceil(COVERAGE_WORKGROUP));
                pass.dispatch_workgroups(x, y, 1);
                if chooses {
                    pass.set_pipeline(&self.choose);
                    pass.dispatch_workgroups(1, 1, 1);
                }
            };
        let of_finest = self.bind_group(device, mask.finest, &coverages, step(0, false));
        count(encoder, &of_finest, mask.levels.size(0), false);
        for level in 1..mask.levels.count {
            let means = &mask.means[level as usize - 1];
            let narrowing = self.bind_group(device, means, &coverages, step(level, false));
            let last = self.bind_group(device, means, &coverages, step(level, true));
            for round in 1..=ROUNDS {
                let bind_group = if round == ROUNDS { &last } else { &narrowing };
                count(encoder, bind_group, mask.levels.size(level), true);
            }
            draw_level(
                encoder,
                pipeline,
                &last,
                &[&mask.levels.view(level, mask.layer)],
            );
        }
    }
}

//! The passes of `coverage.wesl`, which find by how much the alpha of a mask's levels is scaled.

use bevy::render::{
    render_resource::{
        BindGroup, BindGroupEntry, BindGroupLayout, BindGroupLayoutEntries, BindingResource,
        Buffer, BufferInitDescriptor, BufferUsages, CommandEncoder, ComputePassDescriptor,
        ComputePipeline, PipelineCompilationOptions, PipelineLayout, RawComputePipelineDescriptor,
        RenderPipeline, ShaderModule, ShaderStages, ShaderType, TextureView,
        binding_types::{storage_buffer_sized, uniform_buffer_sized},
        encase::UniformBuffer,
    },
    renderer::RenderDevice,
};

use super::{
    chain::LOG_SCALES,
    downsample::{Levels, draw_level, pipeline_layout, shader, source},
};

/// Rounds in which the range of a mask's scales is narrowed, each to a 31st.
const ROUNDS: u32 = 3;
/// Size of `Coverage` in `coverage.wesl`, in bytes.
const COVERAGE_BYTES: usize = 4 * (4 + 32);
const COVERAGE_WORKGROUP: u32 = 8;

/// The pipelines of `coverage.wesl`.
pub(super) struct CoveragePipelines {
    pub shader: ShaderModule,
    layout: BindGroupLayout,
    pub pipeline_layout: PipelineLayout,
    count: ComputePipeline,
    choose: ComputePipeline,
}

/// The levels of a mask whose means are there.
pub(super) struct MaskLevels<'a> {
    pub levels: &'a Levels<'a>,
    pub layer: u32,
    /// The least alpha that is visible.
    pub cutoff: f32,
    /// View of the finest level.
    pub finest: &'a TextureView,
    /// Views of the means in the others.
    pub means: &'a [TextureView],
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
    pub(super) fn new(device: &RenderDevice) -> Option<Self> {
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

    /// Scales the alpha of all levels but the finest one, by the pipeline that draws the scaled levels.
    pub(super) fn scale_alpha(
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

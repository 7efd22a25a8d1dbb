//! Moves stored light along with levels that move by whole voxels.

use bevy::{
    asset::{embedded_asset, load_embedded_asset},
    prelude::*,
    render::{
        diagnostic::RecordDiagnostics,
        render_resource::{
            BindGroup, BindGroupEntries, BindGroupLayoutDescriptor, BindGroupLayoutEntries, Buffer,
            BufferDescriptor, BufferUsages, CachedComputePipelineId, ComputePassDescriptor,
            ComputePipelineDescriptor, PipelineCache, ShaderStages, SpecializedComputePipeline,
            UniformBuffer,
            binding_types::{storage_buffer_read_only_sized, storage_buffer_sized, uniform_buffer},
        },
        renderer::{RenderContext, RenderDevice, RenderQueue},
    },
};

use super::{
    gpu::{GpuVolume, VolumeBuffers, VolumeUniforms},
    placement::MOST_LEVELS,
};

#[derive(Resource)]
pub(crate) struct ScrollPipeline {
    layout: BindGroupLayoutDescriptor,
    shader: Handle<Shader>,
}

pub(crate) fn init_scroll_pipeline(mut commands: Commands, assets: Res<AssetServer>) {
    let layout = BindGroupLayoutDescriptor::new(
        "voxel_gi_scroll",
        &BindGroupLayoutEntries::sequential(
            ShaderStages::COMPUTE,
            (
                uniform_buffer::<GpuVolume>(false),
                uniform_buffer::<[IVec4; MOST_LEVELS]>(false),
                storage_buffer_read_only_sized(false, None),
                storage_buffer_sized(false, None),
            ),
        ),
    );
    let shader = load_embedded_asset!(assets.as_ref(), "scroll.wesl");
    commands.insert_resource(ScrollPipeline { layout, shader });
}

impl SpecializedComputePipeline for ScrollPipeline {
    type Key = ();

    fn specialize(&self, (): Self::Key) -> ComputePipelineDescriptor {
        ComputePipelineDescriptor {
            label: Some("voxel_gi_scroll".into()),
            layout: vec![self.layout.clone()],
            shader: self.shader.clone(),
            entry_point: Some("scroll".into()),
            ..default()
        }
    }
}

/// The work of a frame in which levels have moved.
#[derive(Resource)]
pub(crate) struct ScrollWork {
    pipeline: CachedComputePipelineId,
    bind_group: BindGroup,
    copy: Buffer,
}

impl ScrollWork {
    pub(crate) fn new(
        moves: [IVec4; MOST_LEVELS],
        uniforms: &VolumeUniforms,
        buffers: &VolumeBuffers,
        (pipeline, id): (&ScrollPipeline, CachedComputePipelineId),
        cache: &PipelineCache,
        device: &RenderDevice,
        queue: &RenderQueue,
    ) -> Option<Self> {
        // Allocated for this frame only: volumes move rarely, and a permanent copy would take memory.
        let copy = device.create_buffer(&BufferDescriptor {
            label: Some("voxel_gi_scrolled"),
            size: buffers.irradiance.size(),
            usage: BufferUsages::STORAGE | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut moved = UniformBuffer::from(moves);
        moved.write_buffer(device, queue);
        let bind_group = device.create_bind_group(
            "voxel_gi_scroll",
            &cache.get_bind_group_layout(&pipeline.layout),
            &BindGroupEntries::sequential((
                uniforms.bounces[0].binding()?,
                moved.binding()?,
                copy.as_entire_binding(),
                buffers.irradiance.as_entire_binding(),
            )),
        );
        Some(Self {
            pipeline: id,
            bind_group,
            copy,
        })
    }
}

pub(crate) fn scroll(
    mut context: RenderContext,
    work: Option<Res<ScrollWork>>,
    buffers: Option<Res<VolumeBuffers>>,
    cache: Res<PipelineCache>,
) {
    let (Some(work), Some(buffers)) = (work, buffers) else {
        return;
    };
    let Some(pipeline) = cache.get_compute_pipeline(work.pipeline) else {
        return;
    };
    let diagnostics = context.diagnostic_recorder();
    let encoder = context.command_encoder();
    encoder.copy_buffer_to_buffer(&buffers.irradiance, 0, &work.copy, 0, work.copy.size());
    let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor {
        label: Some("voxel_gi_scroll"),
        ..default()
    });
    let span = diagnostics
        .as_ref()
        .map(|d| d.pass_span(&mut pass, "voxel_gi_scroll"));
    let groups = u32::try_from(buffers.shape.voxels.div_ceil(64)).unwrap_or(u32::MAX);
    let x = groups.min(32768);
    pass.set_pipeline(pipeline);
    pass.set_bind_group(0, &work.bind_group, &[]);
    pass.dispatch_workgroups(x, groups.div_ceil(x), 1);
    if let Some(span) = span {
        span.end(&mut pass);
    }
}

/// Embeds the shader.
pub(crate) fn embed(app: &mut App) {
    embedded_asset!(app, "scroll.wesl");
}

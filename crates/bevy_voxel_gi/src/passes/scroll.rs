//! Moves stored light along with levels that move by whole voxels.

use bevy::{
    asset::{embedded_asset, load_embedded_asset},
    prelude::*,
    render::{
        render_resource::{
            BindGroup, BindGroupEntries, BindGroupLayoutDescriptor, BindGroupLayoutEntries, Buffer,
            BufferDescriptor, BufferUsages, PipelineCache, ShaderStages, UniformBuffer,
            binding_types::uniform_buffer,
        },
        renderer::{RenderContext, RenderDevice, RenderQueue},
    },
};

use super::{
    bindings::{IRRADIANCE, VOXELS_LABEL, VoxelBindGroups, read_only, read_write, voxels_layout},
    kernel::{Kernel, dispatch_voxels, record_pass},
};
use crate::{
    extract::volume::ExtractedVolume,
    gpu_types::MAX_LEVELS,
    prepare::{
        buffers::{BufferShape, VolumeBuffers},
        pipelines::RequiredPipelines,
        plan::FramePlan,
    },
};

/// By how many of its voxels each level has moved, and a copy of the irradiance as it was.
const MOVES: u32 = 9;
const IRRADIANCE_BEFORE: u32 = 10;

#[derive(Resource)]
pub(crate) struct ScrollPass {
    layout: BindGroupLayoutDescriptor,
    scroll: Kernel,
    /// The bind group and the copy, in frames in which levels have moved.
    work: Option<(BindGroup, Buffer)>,
}

pub(crate) fn init(mut commands: Commands, assets: Res<AssetServer>) {
    let layout = BindGroupLayoutDescriptor::new(
        "voxel_gi_scroll",
        &BindGroupLayoutEntries::with_indices(
            ShaderStages::COMPUTE,
            (
                (IRRADIANCE, read_write()),
                (MOVES, uniform_buffer::<[IVec4; MAX_LEVELS]>(false)),
                (IRRADIANCE_BEFORE, read_only()),
            ),
        ),
    );
    let voxels = voxels_layout(VOXELS_LABEL, ShaderStages::COMPUTE);
    let shader = load_embedded_asset!(assets.as_ref(), "scroll.wesl");
    commands.insert_resource(ScrollPass {
        scroll: Kernel::new(
            "voxel_gi_scroll",
            "scroll",
            &shader,
            vec![voxels, layout.clone()],
        ),
        layout,
        work: None,
    });
}

pub(crate) fn queue(
    mut pass: ResMut<ScrollPass>,
    volume: Res<ExtractedVolume>,
    cache: Res<PipelineCache>,
    mut required: ResMut<RequiredPipelines>,
) {
    let shape = volume.0.as_ref().map(BufferShape::of);
    if shape.is_some_and(BufferShape::keeps_light) {
        pass.scroll.require(&[], &cache, &mut required);
    }
}

pub(crate) fn prepare(
    mut pass: ResMut<ScrollPass>,
    plan: Res<FramePlan>,
    buffers: Option<Res<VolumeBuffers>>,
    (cache, device, queue): (Res<PipelineCache>, Res<RenderDevice>, Res<RenderQueue>),
) {
    pass.work = None;
    let (Some(moves), Some(buffers)) = (plan.work.and_then(|work| work.moves), buffers) else {
        return;
    };
    if !buffers.shape.keeps_light() {
        return;
    }
    // Allocated for this frame only: volumes move rarely, and a permanent copy would take memory.
    let copy = device.create_buffer(&BufferDescriptor {
        label: Some("voxel_gi_irradiance_before"),
        size: buffers.irradiance.size(),
        usage: BufferUsages::STORAGE | BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let mut moves = UniformBuffer::from(moves);
    moves.write_buffer(&device, &queue);
    pass.work = moves.binding().map(|moves| {
        let bind_group = device.create_bind_group(
            "voxel_gi_scroll",
            &cache.get_bind_group_layout(&pass.layout),
            &BindGroupEntries::with_indices((
                (IRRADIANCE, buffers.irradiance.as_entire_binding()),
                (MOVES, moves),
                (IRRADIANCE_BEFORE, copy.as_entire_binding()),
            )),
        );
        (bind_group, copy)
    });
}

pub(crate) fn scroll(
    mut context: RenderContext,
    pass: Res<ScrollPass>,
    voxels: Option<Res<VoxelBindGroups>>,
    buffers: Option<Res<VolumeBuffers>>,
    cache: Res<PipelineCache>,
) {
    let (Some((group, copy)), Some(voxels), Some(buffers)) = (&pass.work, voxels, buffers) else {
        return;
    };
    let Some(pipeline) = pass.scroll.pipeline(&cache) else {
        return;
    };
    let encoder = context.command_encoder();
    encoder.copy_buffer_to_buffer(&buffers.irradiance, 0, copy, 0, copy.size());
    record_pass(&mut context, "voxel_gi_scroll", |pass| {
        pass.set_bind_group(0, &voxels.bounces[0], &[]);
        pass.set_bind_group(1, group, &[]);
        dispatch_voxels(pass, pipeline, &buffers);
    });
}

pub(crate) fn embed(app: &mut App) {
    embedded_asset!(app, "scroll.wesl");
}

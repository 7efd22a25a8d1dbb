//! Allocates the slots of the faces that have a surface, between the two passes of voxelisation.

use bevy::{
    asset::{embedded_asset, load_embedded_asset},
    prelude::*,
    render::{
        render_resource::{
            BindGroup, BindGroupLayoutDescriptor, CommandEncoder, ComputePass, PipelineCache,
            UniformBuffer, binding_types::uniform_buffer,
        },
        renderer::RenderQueue,
    },
};

use super::{
    bindings::{
        BindGroups, FACE_SLOTS, IRRADIANCE, VOLUME, WORK, group_layout, read_only, read_write,
        volume_uniform,
    },
    kernel::{Kernel, dispatch_voxels},
};
use crate::{
    extract::volume::ExtractedVolume,
    gpu_types::MAX_LEVELS,
    prepare::{
        buffers::VolumeBuffers, pipelines::RequiredPipelines, plan::FramePlan,
        uniforms::VolumeUniforms,
    },
};

/// By how many of its voxels each level has moved, and copies of irradiance and slots as they were.
const MOVES: u32 = 7;
const IRRADIANCE_BEFORE: u32 = 8;
const FACE_SLOTS_BEFORE: u32 = 9;

#[derive(Resource)]
pub(crate) struct AllocatePass {
    /// Group 0, where the slots are writable.
    voxels_layout: BindGroupLayoutDescriptor,
    layout: BindGroupLayoutDescriptor,
    allocate: Kernel,
    /// By how many of its voxels each level has moved. It is kept as the joints of the voxelisers are.
    moves: UniformBuffer<[IVec4; MAX_LEVELS]>,
    /// In frames that voxelise.
    bind_groups: Option<[BindGroup; 2]>,
}

pub(crate) fn init(mut commands: Commands, assets: Res<AssetServer>) {
    let voxels_layout = group_layout(
        "voxel_gi_allocate_volume",
        ((VOLUME, volume_uniform()), (FACE_SLOTS, read_write())),
    );
    let layout = group_layout(
        "voxel_gi_allocate",
        (
            (WORK, read_write()),
            (IRRADIANCE, read_write()),
            (MOVES, uniform_buffer::<[IVec4; MAX_LEVELS]>(false)),
            (IRRADIANCE_BEFORE, read_only()),
            (FACE_SLOTS_BEFORE, read_only()),
        ),
    );
    let shader = load_embedded_asset!(assets.as_ref(), "allocate.wesl");
    commands.insert_resource(AllocatePass {
        allocate: Kernel::new(
            "voxel_gi_allocate",
            "allocate",
            &shader,
            vec![voxels_layout.clone(), layout.clone()],
        ),
        voxels_layout,
        layout,
        moves: UniformBuffer::default(),
        bind_groups: None,
    });
}

pub(crate) fn queue(
    mut pass: ResMut<AllocatePass>,
    volume: Res<ExtractedVolume>,
    cache: Res<PipelineCache>,
    mut required: ResMut<RequiredPipelines>,
) {
    if volume.0.is_some() {
        pass.allocate.require(&[], &cache, &mut required);
    }
}

pub(crate) fn prepare(
    mut pass: ResMut<AllocatePass>,
    plan: Res<FramePlan>,
    buffers: Option<Res<VolumeBuffers>>,
    uniforms: Res<VolumeUniforms>,
    (groups, queue): (BindGroups, Res<RenderQueue>),
) {
    pass.bind_groups = None;
    let (Some(work), Some(buffers), Some(volume)) =
        (plan.work, buffers, uniforms.bounces[0].binding())
    else {
        return;
    };
    if !work.voxelizes {
        return;
    }
    pass.moves.set(work.moves.unwrap_or_default());
    pass.moves.write_buffer(&groups.device, &queue);
    pass.bind_groups = pass.moves.binding().map(|moves| {
        [
            groups.create(
                &pass.voxels_layout,
                ((VOLUME, volume), (FACE_SLOTS, buffers.face_slots())),
            ),
            groups.create(
                &pass.layout,
                (
                    (WORK, buffers.work.as_entire_binding()),
                    (IRRADIANCE, buffers.irradiance.as_entire_binding()),
                    (MOVES, moves),
                    (IRRADIANCE_BEFORE, buffers.irradiance_before()),
                    (
                        FACE_SLOTS_BEFORE,
                        buffers.face_slots_before.as_entire_binding(),
                    ),
                ),
            ),
        ]
    });
}

/// Keeps the slots and their light as they are now, for `allocate.wesl`.
pub(super) fn keep_slots(encoder: &mut CommandEncoder, buffers: &VolumeBuffers) {
    for (from, to, bytes) in [
        (
            &buffers.irradiance,
            &buffers.sums,
            buffers.irradiance.size(),
        ),
        (
            &buffers.voxels,
            &buffers.face_slots_before,
            buffers.face_slots_before.size(),
        ),
    ] {
        encoder.copy_buffer_to_buffer(from, 0, to, 0, bytes);
    }
}

impl AllocatePass {
    /// Records the pass.
    pub(super) fn record(
        &self,
        pass: &mut ComputePass<'_>,
        buffers: &VolumeBuffers,
        cache: &PipelineCache,
    ) {
        if let (Some(groups), Some(allocate)) = (&self.bind_groups, self.allocate.pipeline(cache)) {
            for (i, group) in (0..).zip(groups) {
                pass.set_bind_group(i, group, &[]);
            }
            dispatch_voxels(pass, allocate, buffers);
        }
    }
}

pub(crate) fn embed(app: &mut App) {
    embedded_asset!(app, "allocate.wesl");
}

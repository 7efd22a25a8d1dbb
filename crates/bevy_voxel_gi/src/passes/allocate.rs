//! Allocates the slots of the faces that have a surface, between the two passes of voxelisation.

use bevy::{
    asset::{embedded_asset, load_embedded_asset},
    prelude::*,
    render::render_resource::{
        BindGroup, BindGroupLayoutDescriptor, CommandEncoder, ComputePass, PipelineCache,
    },
};

use super::{
    bindings::{
        BindGroups, CHANGES, DIRTY, FACE_SLOTS, IRRADIANCE, PACKED_SURFACES, SLOT_LISTS, SUMS,
        VOLUME, changes_uniform, group_layout, read_only, read_write, volume_uniform,
    },
    kernel::{Kernel, dispatch_voxels},
};
use crate::{
    extract::volume::ExtractedVolume,
    prepare::{
        buffers::VolumeBuffers, pipelines::RequiredPipelines, plan::FramePlan,
        uniforms::VolumeUniforms,
    },
};

#[derive(Resource)]
pub(crate) struct AllocatePass {
    voxels_layout: BindGroupLayoutDescriptor,
    layout: BindGroupLayoutDescriptor,
    allocate: Kernel,
    /// In frames that voxelise.
    bind_groups: Option<[BindGroup; 2]>,
}

pub(crate) fn init(mut commands: Commands, assets: Res<AssetServer>) {
    let voxels_layout = group_layout(
        "voxel_gi_allocate_volume",
        (
            (VOLUME, volume_uniform()),
            (PACKED_SURFACES, read_write()),
            (FACE_SLOTS, read_write()),
            (SUMS, read_write()),
        ),
    );
    let layout = group_layout(
        "voxel_gi_allocate",
        (
            (IRRADIANCE, read_write()),
            (CHANGES, changes_uniform()),
            (DIRTY, read_only()),
            (SLOT_LISTS, read_write()),
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
    groups: BindGroups,
) {
    pass.bind_groups = None;
    let (Some(_), Some(buffers), Some(volume), Some(changes)) = (
        plan.work.and_then(|work| work.voxelizes),
        buffers,
        uniforms.bounces[0].binding(),
        uniforms.changes.binding(),
    ) else {
        return;
    };
    pass.bind_groups = Some([
        groups.create(
            &pass.voxels_layout,
            (
                (VOLUME, volume),
                (PACKED_SURFACES, buffers.packed_surfaces.as_entire_binding()),
                (FACE_SLOTS, buffers.face_slots()),
                (SUMS, buffers.sums.as_entire_binding()),
            ),
        ),
        groups.create(
            &pass.layout,
            (
                (IRRADIANCE, buffers.irradiance.as_entire_binding()),
                (CHANGES, changes),
                (DIRTY, buffers.work.as_entire_binding()),
                (SLOT_LISTS, buffers.slot_lists.as_entire_binding()),
            ),
        ),
    ]);
}

/// Keeps the slots and their light as they are now, for `allocate.wesl`.
pub(super) fn keep_slots(encoder: &mut CommandEncoder, buffers: &VolumeBuffers) {
    let light = buffers.irradiance.size();
    encoder.copy_buffer_to_buffer(&buffers.irradiance, 0, &buffers.sums, 0, light);
    let (offset, words) = buffers.former_slot_words();
    encoder.copy_buffer_to_buffer(&buffers.voxels, 0, &buffers.work, offset, words);
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

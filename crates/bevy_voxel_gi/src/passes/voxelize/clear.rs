//! Empties the voxels that are voxelised anew, and moves the others in levels that have moved.

use bevy::{
    asset::{embedded_asset, load_embedded_asset},
    prelude::*,
    render::render_resource::{BindGroup, BindGroupLayoutDescriptor, ComputePass, PipelineCache},
};

use super::super::{
    bindings::{
        BindGroups, CHANGES, DIRTY, FACE_SLOTS, MASKS, PACKED_SURFACES, SLOT_LISTS, VOLUME,
        changes_uniform, group_layout, read_only, read_write, volume_uniform,
    },
    kernel::{Kernel, dispatch_voxels},
};
use crate::prepare::{
    buffers::VolumeBuffers, pipelines::RequiredPipelines, uniforms::VolumeUniforms,
    voxelization::Voxelization,
};

pub(super) struct ClearPass {
    voxels_layout: BindGroupLayoutDescriptor,
    layout: BindGroupLayoutDescriptor,
    clear: Kernel,
    /// Moves masks along each axis.
    moves: [Kernel; 3],
    bind_groups: Option<[BindGroup; 2]>,
    /// Rows of masks along one edge of a level, and the number of levels, of which those of meshes that shadow direct
    /// light count, too.
    rows: [u32; 2],
}

impl ClearPass {
    pub(super) fn new(assets: &AssetServer) -> Self {
        let voxels_layout = group_layout(
            "voxel_gi_clear_volume",
            (
                (VOLUME, volume_uniform()),
                (MASKS, read_write()),
                (PACKED_SURFACES, read_write()),
                (FACE_SLOTS, read_write()),
            ),
        );
        let layout = group_layout(
            "voxel_gi_clear",
            (
                (CHANGES, changes_uniform()),
                (DIRTY, read_only()),
                (SLOT_LISTS, read_write()),
            ),
        );
        let shader = load_embedded_asset!(assets, "clear.wesl");
        let kernel = |label, entry_point| {
            let layouts = vec![voxels_layout.clone(), layout.clone()];
            Kernel::new(label, entry_point, &shader, layouts)
        };
        Self {
            clear: kernel("voxel_gi_clear", "clear"),
            moves: ["move_along_x", "move_along_y", "move_along_z"]
                .map(|entry_point| kernel("voxel_gi_move", entry_point)),
            voxels_layout,
            layout,
            bind_groups: None,
            rows: [0; 2],
        }
    }

    pub(super) fn queue(
        &mut self,
        shadow_masks: Option<&'static str>,
        cache: &PipelineCache,
        required: &mut RequiredPipelines,
    ) {
        for kernel in self.moves.iter_mut().chain([&mut self.clear]) {
            kernel.require(shadow_masks.as_slice(), cache, required);
        }
    }

    pub(super) fn prepare(
        &mut self,
        rows: [u32; 2],
        buffers: &VolumeBuffers,
        uniforms: &VolumeUniforms,
        groups: &BindGroups,
    ) -> Option<()> {
        let volume = uniforms.bounces[0].binding()?;
        self.rows = rows;
        self.bind_groups = Some([
            groups.create(
                &self.voxels_layout,
                (
                    (VOLUME, volume),
                    (MASKS, buffers.masks()),
                    (PACKED_SURFACES, buffers.packed_surfaces.as_entire_binding()),
                    (FACE_SLOTS, buffers.face_slots()),
                ),
            ),
            groups.create(
                &self.layout,
                (
                    (CHANGES, uniforms.changes.binding()?),
                    (DIRTY, buffers.work.as_entire_binding()),
                    (SLOT_LISTS, buffers.slot_lists.as_entire_binding()),
                ),
            ),
        ]);
        Some(())
    }

    pub(super) fn record(
        &self,
        pass: &mut ComputePass<'_>,
        voxelizes: Voxelization,
        buffers: &VolumeBuffers,
        cache: &PipelineCache,
    ) {
        let (Some(groups), Some(clear)) = (&self.bind_groups, self.clear.pipeline(cache)) else {
            return;
        };
        for (i, group) in (0..).zip(groups) {
            pass.set_bind_group(i, group, &[]);
        }
        if let Voxelization::Part { moved } = voxelizes {
            let [rows, levels] = self.rows;
            let kernels = self.moves.iter().enumerate();
            for (_, kernel) in kernels.filter(|(axis, _)| moved.test(*axis)) {
                if let Some(pipeline) = kernel.pipeline(cache) {
                    pass.set_pipeline(pipeline);
                    pass.dispatch_workgroups(rows, rows, levels);
                }
            }
        }
        dispatch_voxels(pass, clear, buffers);
    }
}

pub(super) fn embed(app: &mut App) {
    embedded_asset!(app, "clear.wesl");
}

//! Adds what cameras saw to the voxels; see `mark_visible`.

use bevy::{
    asset::{embedded_asset, load_embedded_asset},
    prelude::*,
    render::render_resource::{
        BindGroup, BindGroupLayoutDescriptor, CommandEncoder, ComputePass, ComputePipeline,
        PipelineCache,
    },
};

use super::{
    super::{
        bindings::{BindGroups, VISIBLE, group_layout, read_only},
        kernel::dispatch_voxels,
    },
    kernels::Kernels,
};
use crate::prepare::{buffers::VolumeBuffers, pipelines::RequiredPipelines};

pub(super) struct VisibleVoxels {
    layout: BindGroupLayoutDescriptor,
    kernels: Kernels,
    /// In frames that voxelise what is visible.
    bind_group: Option<BindGroup>,
}

impl VisibleVoxels {
    pub(super) fn new(
        voxels_layouts: &[BindGroupLayoutDescriptor; 2],
        assets: &AssetServer,
    ) -> Self {
        let layout = group_layout("voxel_gi_visible", ((VISIBLE, read_only()),));
        let shader = load_embedded_asset!(assets, "visible.wesl");
        Self {
            kernels: Kernels::new(
                ["voxel_gi_visible", "voxel_gi_visible_surfaces"],
                &shader,
                voxels_layouts,
                &layout,
            ),
            layout,
            bind_group: None,
        }
    }

    pub(super) fn queue(
        &mut self,
        shadow_masks: Option<&'static str>,
        cache: &PipelineCache,
        required: &mut RequiredPipelines,
    ) {
        self.kernels
            .require([shadow_masks.as_slice(), &[]], cache, required);
    }

    pub(super) fn prepare(&mut self, buffers: &VolumeBuffers, groups: &BindGroups) {
        self.bind_group = buffers.shape.marks_visible.then(|| {
            groups.create(
                &self.layout,
                ((VISIBLE, buffers.visible.as_entire_binding()),),
            )
        });
    }

    /// The pipelines of the two passes, in frames that voxelise what is visible.
    pub(super) fn pipelines<'a>(
        &self,
        cache: &'a PipelineCache,
    ) -> Option<[&'a ComputePipeline; 2]> {
        self.bind_group.as_ref()?;
        self.kernels.pipelines(cache)
    }

    /// Records one of the two passes; group 0 is `voxels`.
    pub(super) fn record(
        &self,
        pass: &mut ComputePass<'_>,
        pipeline: &ComputePipeline,
        voxels: &BindGroup,
        buffers: &VolumeBuffers,
    ) {
        if let Some(group) = &self.bind_group {
            pass.set_bind_group(0, voxels, &[]);
            pass.set_bind_group(1, group, &[]);
            dispatch_voxels(pass, pipeline, buffers);
        }
    }

    /// Clears the marks of the frames before, which a change in the scene has made invalid.
    pub(super) fn clear(&self, encoder: &mut CommandEncoder, buffers: &VolumeBuffers) {
        if self.bind_group.is_some() {
            encoder.clear_buffer(&buffers.visible, 0, None);
        }
    }
}

pub(super) fn embed(app: &mut App) {
    embedded_asset!(app, "visible.wesl");
}

//! Chooses the triangles that are voxelised; see `cull.wesl`.

use bevy::{
    asset::{embedded_asset, load_embedded_asset},
    prelude::*,
    render::{
        render_resource::{
            BindGroup, BindGroupLayoutDescriptor, Buffer, BufferDescriptor, BufferUsages,
            CommandEncoder, ComputePass, PipelineCache,
        },
        renderer::RenderDevice,
    },
};

use super::super::{
    bindings::{BindGroups, DIRTY, VOLUME, group_layout, read_only, read_write, volume_uniform},
    kernel::{Kernel, dispatch_workgroups},
};
use crate::prepare::{
    buffers::VolumeBuffers,
    mesh_group::{MeshGroup, UploadedGroup},
    pipelines::RequiredPipelines,
    uniforms::VolumeUniforms,
};

// Group 1, whose first numbers are those of the voxelisers.
const VERTICES: u32 = 0;
const INDICES: u32 = 1;
const INSTANCES: u32 = 2;
const ITEMS: u32 = 3;
const BATCHES: u32 = 14;

/// Size of indirect dispatch arguments in bytes.
const ARGS_SIZE: u64 = 12;

pub(super) struct CullPass {
    voxels_layout: BindGroupLayoutDescriptor,
    layout: BindGroupLayoutDescriptor,
    cull: Kernel,
    write_args: Kernel,
    voxels: Option<BindGroup>,
    groups: Vec<CulledGroup>,
    /// The copy of the arguments of all groups that indirect dispatches read.
    args: Option<Buffer>,
}

struct CulledGroup {
    bind_group: BindGroup,
    batch_count: u32,
    items: Buffer,
}

impl CullPass {
    pub(super) fn new(assets: &AssetServer) -> Self {
        let voxels_layout = group_layout("voxel_gi_cull_volume", ((VOLUME, volume_uniform()),));
        let layout = group_layout(
            "voxel_gi_cull",
            (
                (VERTICES, read_only()),
                (INDICES, read_only()),
                (INSTANCES, read_only()),
                (ITEMS, read_write()),
                (DIRTY, read_only()),
                (BATCHES, read_write()),
            ),
        );
        let shader = load_embedded_asset!(assets, "cull.wesl");
        let kernel = |label, entry_point| {
            let layouts = vec![voxels_layout.clone(), layout.clone()];
            Kernel::new(label, entry_point, &shader, layouts)
        };
        Self {
            cull: kernel("voxel_gi_cull", "cull"),
            write_args: kernel("voxel_gi_write_cull_args", "write_args"),
            voxels_layout,
            layout,
            voxels: None,
            groups: Vec::new(),
            args: None,
        }
    }

    pub(super) fn queue(&mut self, cache: &PipelineCache, required: &mut RequiredPipelines) {
        self.cull.require(&[], cache, required);
        self.write_args.require(&[], cache, required);
    }

    /// Forgets the groups of the last frame.
    pub(super) fn begin(&mut self, uniforms: &VolumeUniforms, groups: &BindGroups) -> Option<()> {
        self.groups.clear();
        let volume = uniforms.bounces[0].binding()?;
        self.voxels = Some(groups.create(&self.voxels_layout, ((VOLUME, volume),)));
        Some(())
    }

    pub(super) fn add(
        &mut self,
        [vertices, indices, _]: &[Buffer; 3],
        group: &UploadedGroup,
        buffers: &VolumeBuffers,
        groups: &BindGroups,
    ) {
        let bind_group = groups.create(
            &self.layout,
            (
                (VERTICES, vertices.as_entire_binding()),
                (INDICES, indices.as_entire_binding()),
                (INSTANCES, group.instances.items.clone()),
                (ITEMS, group.items.as_entire_binding()),
                (DIRTY, buffers.work.as_entire_binding()),
                (BATCHES, group.batches.items.clone()),
            ),
        );
        self.groups.push(CulledGroup {
            bind_group,
            batch_count: group.batch_count,
            items: group.items.clone(),
        });
    }

    /// Makes room for the arguments of all groups.
    pub(super) fn finish(&mut self, device: &RenderDevice) {
        let size = ARGS_SIZE * self.groups.len().max(1) as u64;
        if self.args.as_ref().is_none_or(|args| args.size() < size) {
            self.args = Some(device.create_buffer(&BufferDescriptor {
                label: Some("voxel_gi_cull_args"),
                size,
                usage: BufferUsages::INDIRECT | BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }));
        }
    }

    pub(super) fn clear_counts(&self, encoder: &mut CommandEncoder) {
        for group in &self.groups {
            encoder.clear_buffer(&group.items, 0, Some(MeshGroup::ITEMS_HEADER));
        }
    }

    pub(super) fn record(&self, pass: &mut ComputePass<'_>, cache: &PipelineCache) {
        let (Some(cull), Some(write_args), Some(voxels)) = (
            self.cull.pipeline(cache),
            self.write_args.pipeline(cache),
            &self.voxels,
        ) else {
            return;
        };
        pass.set_bind_group(0, voxels, &[]);
        for group in &self.groups {
            pass.set_bind_group(1, &group.bind_group, &[]);
            pass.set_pipeline(cull);
            dispatch_workgroups(pass, group.batch_count.div_ceil(64));
            pass.set_pipeline(write_args);
            pass.dispatch_workgroups(1, 1, 1);
        }
    }

    /// Copies the arguments: a buffer cannot be both writable storage and indirect arguments in one pass.
    pub(super) fn copy_args(&self, encoder: &mut CommandEncoder) {
        if let Some(args) = &self.args {
            for (i, group) in (0..).zip(&self.groups) {
                encoder.copy_buffer_to_buffer(&group.items, 0, args, ARGS_SIZE * i, ARGS_SIZE);
            }
        }
    }

    /// The numbers of batches that are voxelised, in their buffers.
    pub(super) fn counts(&self) -> impl ExactSizeIterator<Item = (&Buffer, u64)> {
        let groups = self.groups.iter();
        groups.map(|group| (&group.items, ARGS_SIZE))
    }

    /// Dispatches a workgroup for each batch of a group that is voxelised.
    pub(super) fn dispatch(&self, pass: &mut ComputePass<'_>, group: usize) {
        if let Some(args) = &self.args {
            pass.dispatch_workgroups_indirect(args, ARGS_SIZE * group as u64);
        }
    }
}

pub(super) fn embed(app: &mut App) {
    embedded_asset!(app, "cull.wesl");
}

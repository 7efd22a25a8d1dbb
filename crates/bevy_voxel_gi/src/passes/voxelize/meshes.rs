//! What is done with the lists of meshes before these are voxelised: their changes are written, and the triangles are
//! chosen.

use bevy::{
    asset::load_embedded_asset,
    prelude::*,
    render::{
        render_resource::{
            BindGroup, BindGroupEntries, BindGroupLayoutDescriptor, Buffer, BufferUsages,
            CommandEncoder, ComputePass, PipelineCache,
        },
        renderer::RenderDevice,
    },
};

use super::super::{
    bindings::{
        Access::{Read, Write},
        BindGroups, Binding, Group, group_layout, storage,
    },
    kernel::{Kernel, Pipelines, dispatch_workgroups},
};
use crate::prepare::{
    buffers::buffer,
    mesh_group::{MeshGroup, UploadedGroup, UploadedList},
};

/// Writes what has changed of the lists: a copy for each place would take the CPU far longer where many meshes move.
pub(super) struct ScatterPass {
    layout: BindGroupLayoutDescriptor,
    scatter: Kernel,
    /// The lists, and the numbers of words that have changed.
    lists: Vec<(BindGroup, u32)>,
}

impl ScatterPass {
    pub(super) fn new(assets: &AssetServer) -> Self {
        let layout = group_layout(
            "voxel_gi_scatter",
            ((0, storage(Write)), (1, storage(Read))),
        );
        let shader = load_embedded_asset!(assets, "scatter.wesl");
        Self {
            scatter: Kernel::new("voxel_gi_scatter", "scatter", &shader, &[&layout]),
            layout,
            lists: Vec::new(),
        }
    }

    pub(super) fn queue(&mut self, pipelines: &mut Pipelines) {
        self.scatter.require(&[], pipelines);
    }

    pub(super) fn begin(&mut self) {
        self.lists.clear();
    }

    pub(super) fn add(&mut self, list: &UploadedList, groups: &BindGroups) {
        if let Some(changes) = &list.changes {
            let entries = BindGroupEntries::sequential((list.items.clone(), changes.clone()));
            let bind_group = groups.create(&self.layout, &entries);
            self.lists.push((bind_group, list.change_count));
        }
    }

    pub(super) fn record(&self, pass: &mut ComputePass<'_>, cache: &PipelineCache) {
        let Some(scatter) = self.scatter.pipeline(cache) else {
            return;
        };
        pass.set_pipeline(scatter);
        for (bind_group, count) in &self.lists {
            pass.set_bind_group(0, bind_group, &[]);
            dispatch_workgroups(pass, count.div_ceil(64));
        }
    }
}

// Group 1 of culling, whose first numbers are those of the voxelisers.
const VERTICES: u32 = 0;
const INDICES: u32 = 1;
const INSTANCES: u32 = 2;
const ITEMS: u32 = 3;
const DIRTY: u32 = Binding::Dirty.number();
const BATCHES: u32 = 14;

/// Size of indirect dispatch arguments in bytes.
const ARGS_SIZE: u64 = 12;

/// Chooses the triangles that are voxelised; see `cull.wesl`.
pub(super) struct CullPass {
    voxels_group: Group,
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
        let voxels_group = Group::new("voxel_gi_cull_volume", &[Binding::Volume(0)], &[]);
        let layout = group_layout(
            "voxel_gi_cull",
            (
                (VERTICES, storage(Read)),
                (INDICES, storage(Read)),
                (INSTANCES, storage(Read)),
                (ITEMS, storage(Write)),
                (DIRTY, storage(Read)),
                (BATCHES, storage(Write)),
            ),
        );
        let shader = load_embedded_asset!(assets, "cull.wesl");
        let kernel = |label, entry_point| {
            Kernel::new(
                label,
                entry_point,
                &shader,
                &[&voxels_group.layout, &layout],
            )
        };
        Self {
            cull: kernel("voxel_gi_cull", "cull"),
            write_args: kernel("voxel_gi_write_cull_args", "write_args"),
            voxels_group,
            layout,
            voxels: None,
            groups: Vec::new(),
            args: None,
        }
    }

    pub(super) fn queue(&mut self, pipelines: &mut Pipelines) {
        self.cull.require(&[], pipelines);
        self.write_args.require(&[], pipelines);
    }

    pub(super) fn begin(&mut self, groups: &BindGroups) -> Option<()> {
        self.groups.clear();
        self.voxels = Some(groups.bind(&self.voxels_group)?);
        Some(())
    }

    pub(super) fn add(
        &mut self,
        [vertices, indices, _]: &[Buffer; 3],
        group: &UploadedGroup,
        groups: &BindGroups,
    ) {
        let Some(buffers) = &groups.buffers else {
            return;
        };
        let entries = BindGroupEntries::with_indices((
            (VERTICES, vertices.as_entire_binding()),
            (INDICES, indices.as_entire_binding()),
            (INSTANCES, group.instances.items.clone()),
            (ITEMS, group.items.as_entire_binding()),
            (DIRTY, buffers.work.as_entire_binding()),
            (BATCHES, group.batches.items.clone()),
        ));
        self.groups.push(CulledGroup {
            bind_group: groups.create(&self.layout, &entries),
            batch_count: group.batch_count,
            items: group.items.clone(),
        });
    }

    pub(super) fn finish(&mut self, device: &RenderDevice) {
        let size = ARGS_SIZE * self.groups.len().max(1) as u64;
        if self.args.as_ref().is_none_or(|args| args.size() < size) {
            let usage = BufferUsages::INDIRECT | BufferUsages::COPY_DST;
            self.args = Some(buffer(device, "voxel_gi_cull_args", size, usage));
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

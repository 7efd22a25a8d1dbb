//! Writes what has changed of the lists of meshes: a copy for each place would take the CPU far longer where many
//! meshes move.

use bevy::{
    asset::{embedded_asset, load_embedded_asset},
    prelude::*,
    render::render_resource::{BindGroup, BindGroupLayoutDescriptor, ComputePass, PipelineCache},
};

use super::super::{
    bindings::{BindGroups, group_layout, read_only, read_write},
    kernel::{Kernel, dispatch_workgroups},
};
use crate::prepare::{mesh_group::UploadedList, pipelines::RequiredPipelines};

// Group 0.
const WORDS: u32 = 0;
const CHANGES: u32 = 1;

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
            ((WORDS, read_write()), (CHANGES, read_only())),
        );
        let shader = load_embedded_asset!(assets, "scatter.wesl");
        Self {
            scatter: Kernel::new("voxel_gi_scatter", "scatter", &shader, vec![layout.clone()]),
            layout,
            lists: Vec::new(),
        }
    }

    pub(super) fn queue(&mut self, cache: &PipelineCache, required: &mut RequiredPipelines) {
        self.scatter.require(&[], cache, required);
    }

    /// Forgets the lists of the last frame.
    pub(super) fn begin(&mut self) {
        self.lists.clear();
    }

    pub(super) fn add(&mut self, list: &UploadedList, groups: &BindGroups) {
        if let Some(changes) = &list.changes {
            let entries = ((WORDS, list.items.clone()), (CHANGES, changes.clone()));
            let bind_group = groups.create(&self.layout, entries);
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

pub(super) fn embed(app: &mut App) {
    embedded_asset!(app, "scatter.wesl");
}

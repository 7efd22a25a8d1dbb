//! The kernels of the two passes of voxelisation.

use bevy::{
    prelude::*,
    render::render_resource::{BindGroupLayoutDescriptor, ComputePipeline, PipelineCache},
};

use super::super::kernel::Kernel;
use crate::prepare::pipelines::RequiredPipelines;

/// The two passes of a voxeliser.
pub(super) struct Kernels {
    /// Marks occupied sub-voxels, and the faces with a surface.
    occupancy: Kernel,
    /// Writes the surfaces, once the faces have slots.
    surfaces: Kernel,
}

impl Kernels {
    /// `labels` are of the two passes.
    pub(super) fn new(
        labels: [&'static str; 2],
        shader: &Handle<Shader>,
        layout: &[&BindGroupLayoutDescriptor],
    ) -> Self {
        let kernel = |label| {
            let layout = layout.iter().copied().cloned().collect();
            Kernel::new(label, "voxelize", shader, layout)
        };
        Self {
            occupancy: kernel(labels[0]),
            surfaces: kernel(labels[1]),
        }
    }

    /// Chooses the variants with these shader defs for this frame, which waits until they are ready.
    pub(super) fn require(
        &mut self,
        mut defs: Vec<&'static str>,
        cache: &PipelineCache,
        required: &mut RequiredPipelines,
    ) {
        self.occupancy.require(&defs, cache, required);
        defs.push("SURFACES");
        self.surfaces.require(&defs, cache, required);
    }

    /// The pipelines of both passes, if they are ready.
    pub(super) fn pipelines<'a>(
        &self,
        cache: &'a PipelineCache,
    ) -> Option<[&'a ComputePipeline; 2]> {
        Some([
            self.occupancy.pipeline(cache)?,
            self.surfaces.pipeline(cache)?,
        ])
    }
}

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
    /// `labels` and `voxels` are of the two passes, `source` is the layout of what both read.
    pub(super) fn new(
        labels: [&'static str; 2],
        shader: &Handle<Shader>,
        voxels: &[BindGroupLayoutDescriptor; 2],
        source: &BindGroupLayoutDescriptor,
    ) -> Self {
        let kernel = |pass: usize| {
            let layout = vec![voxels[pass].clone(), source.clone()];
            Kernel::new(labels[pass], "voxelize", shader, layout)
        };
        Self {
            occupancy: kernel(0),
            surfaces: kernel(1),
        }
    }

    /// Chooses the variants of the two passes with these shader defs for this frame, which waits until they are ready.
    pub(super) fn require(
        &mut self,
        [of_occupancy, of_surfaces]: [&[&'static str]; 2],
        cache: &PipelineCache,
        required: &mut RequiredPipelines,
    ) {
        self.occupancy.require(of_occupancy, cache, required);
        let of_surfaces = [of_surfaces, &["SURFACES"]].concat();
        self.surfaces.require(&of_surfaces, cache, required);
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

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

    /// Chooses the variants with these shader defs, and another one of occupancy, for this frame, which waits until they
    /// are ready.
    pub(super) fn require(
        &mut self,
        defs: &[&'static str],
        of_occupancy: Option<&'static str>,
        cache: &PipelineCache,
        required: &mut RequiredPipelines,
    ) {
        let with = |own| defs.iter().copied().chain(own).collect::<Vec<_>>();
        self.occupancy.require(&with(of_occupancy), cache, required);
        self.surfaces
            .require(&with(Some("SURFACES")), cache, required);
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

//! The pipelines that a frame needs.

use bevy::{
    prelude::*,
    render::render_resource::{CachedComputePipelineId, PipelineCache},
};

/// The pipelines that the passes of this frame need: light is computed only once all are ready.
#[derive(Resource, Default)]
pub(crate) struct RequiredPipelines(Vec<CachedComputePipelineId>);

impl RequiredPipelines {
    /// Adds a pipeline, in each frame that needs it.
    pub(crate) fn add(&mut self, id: CachedComputePipelineId) {
        self.0.push(id);
    }

    /// Empties the list; returns whether all pipelines in it are ready.
    pub(super) fn take_ready(&mut self, cache: &PipelineCache) -> bool {
        self.0.drain(..).fold(true, |all, id| {
            all & cache.get_compute_pipeline(id).is_some()
        })
    }
}

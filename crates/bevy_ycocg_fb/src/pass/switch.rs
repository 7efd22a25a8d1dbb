//! The frame in which a view has switched formats waits for its pipelines, so that no mesh is missing in it: what is
//! on the screen stays there until then.

use bevy::{
    prelude::*,
    render::render_resource::{
        CachedPipelineState, CachedRenderPipelineId, PipelineCache, PipelineDescriptor,
    },
};

use crate::view::eligibility::SwitchedViews;

pub(super) fn wait_for_pipelines(switched: Res<SwitchedViews>, mut cache: ResMut<PipelineCache>) {
    if switched.views.is_empty() {
        return;
    }
    cache.process_queue();
    let is_creating = |(id, pipeline): (usize, &bevy::render::render_resource::CachedPipeline)| {
        let is_compute = matches!(
            pipeline.descriptor,
            PipelineDescriptor::ComputePipelineDescriptor(_)
        );
        let is_creating = matches!(pipeline.state, CachedPipelineState::Creating(_));
        (is_creating && !is_compute).then(|| CachedRenderPipelineId::new(id))
    };
    let ids: Vec<_> = cache
        .pipelines()
        .enumerate()
        .filter_map(is_creating)
        .collect();
    for id in ids {
        cache.block_on_render_pipeline(id);
    }
}

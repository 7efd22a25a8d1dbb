//! Computes the light: each bounce of ray tracing, or all steps of propagation.

use bevy::{
    prelude::*,
    render::{render_resource::PipelineCache, renderer::RenderContext},
};

use super::{
    bindings::VoxelBindGroups, gather::GatherPass, inject::InjectPass, kernel::record_pass,
    propagate::PropagatePass,
};
use crate::prepare::{buffers::VolumeBuffers, plan::FramePlan, uniforms::uniform_of};

pub(crate) fn solve(
    mut context: RenderContext,
    plan: Res<FramePlan>,
    voxels: Option<Res<VoxelBindGroups>>,
    buffers: Option<Res<VolumeBuffers>>,
    (inject, gather, propagate): (Res<InjectPass>, Res<GatherPass>, Res<PropagatePass>),
    cache: Res<PipelineCache>,
) {
    let (Some(work), Some(voxels), Some(buffers)) = (plan.work, voxels, buffers) else {
        return;
    };
    let record_inject = |context: &mut RenderContext, bounce: usize| {
        if !buffers.shape.occlusion_only {
            record_pass(context, "voxel_gi_inject", |pass| {
                pass.set_bind_group(0, &voxels.bounces[bounce], &[]);
                inject.record(pass, &buffers, &cache);
            });
        }
    };
    if buffers.shape.propagates {
        record_inject(&mut context, 0);
        record_pass(&mut context, "voxel_gi_propagate", |pass| {
            pass.set_bind_group(0, &voxels.bounces[0], &[]);
            propagate.record(pass, work.iterations, &buffers, &cache);
        });
        return;
    }
    for bounce in 0..work.bounces {
        let group = uniform_of(bounce, work.bounces);
        record_inject(&mut context, group);
        record_pass(&mut context, "voxel_gi_gather", |pass| {
            pass.set_bind_group(0, &voxels.bounces[group], &[]);
            gather.record_gather(pass, bounce + 1 == work.bounces, &buffers, &cache);
        });
    }
    if buffers.shape.shares_light() && !work.is_held {
        record_pass(&mut context, "voxel_gi_share", |pass| {
            pass.set_bind_group(0, &voxels.bounces[0], &[]);
            gather.record_share(pass, &buffers, &cache);
        });
    }
}

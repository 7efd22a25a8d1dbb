//! Registers the passes.

use bevy::{
    core_pipeline::{Core3d, Core3dSystems, schedule::camera_driver},
    prelude::*,
    render::{
        GpuResourceAppExt, Render, RenderApp, RenderStartup, RenderSystems,
        renderer::{RenderGraph, RenderGraphSystems},
    },
    shader::load_shader_library,
};

use super::{
    allocate,
    bindings::{VoxelBindGroups, prepare_voxel_bind_groups},
    compact, draw_sky, draw_tiles, gather, inject, mark_visible, propagate, read_back, reproject,
    solve::solve,
    voxelize,
};
use crate::prepare::{
    light_tiles::prepare_light_tiles,
    plan::{FramePlan, plan_frame},
};

/// Registers the passes.
pub(crate) struct PassesPlugin;

impl Plugin for PassesPlugin {
    fn build(&self, app: &mut App) {
        load_shader_library!(app, "bindings.wesl");
        load_shader_library!(app, "dirty.wesl");
        load_shader_library!(app, "g_buffer.wesl");
        load_shader_library!(app, "projection.wesl");
        load_shader_library!(app, "tiles.wesl");
        load_shader_library!(app, "voxelize/materials.wesl");
        load_shader_library!(app, "voxelize/plane.wesl");
        load_shader_library!(app, "voxelize/polygon.wesl");
        load_shader_library!(app, "voxelize/sums.wesl");
        load_shader_library!(app, "voxelize/triangles.wesl");
        load_shader_library!(app, "voxelize/vertices.wesl");
        draw_sky::embed(app);
        draw_tiles::embed(app);
        voxelize::embed(app);
        allocate::embed(app);
        compact::embed(app);
        inject::embed(app);
        gather::embed(app);
        propagate::embed(app);
        reproject::embed(app);
        mark_visible::embed(app);
    }

    fn finish(&self, app: &mut App) {
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        render_app
            .init_gpu_resource::<read_back::CountsCopy>()
            .init_gpu_resource::<draw_sky::SkyCube>()
            .add_systems(
                RenderStartup,
                (
                    draw_sky::init,
                    draw_tiles::init,
                    voxelize::init,
                    allocate::init,
                    compact::init,
                    inject::init,
                    gather::init,
                    propagate::init,
                    reproject::init,
                    mark_visible::init,
                ),
            )
            .add_systems(
                Render,
                (
                    draw_sky::note_sky,
                    draw_sky::queue.after(draw_sky::note_sky),
                    draw_tiles::queue,
                    voxelize::queue,
                    allocate::queue,
                    compact::queue,
                    inject::queue,
                    gather::queue.after(draw_sky::note_sky),
                    propagate::queue.after(draw_sky::note_sky),
                    reproject::queue,
                    mark_visible::queue,
                )
                    .in_set(RenderSystems::PrepareResources)
                    .after(prepare_light_tiles)
                    .before(plan_frame),
            )
            .add_systems(
                Render,
                (
                    prepare_voxel_bind_groups,
                    voxelize::prepare,
                    allocate::prepare,
                    compact::prepare,
                    inject::prepare,
                    gather::prepare,
                    propagate::prepare,
                )
                    .in_set(RenderSystems::PrepareBindGroups)
                    .after(plan_frame)
                    .run_if(light_is_computed),
            )
            .add_systems(Render, read_back::read_back.in_set(RenderSystems::Cleanup))
            .add_systems(
                Core3d,
                (reproject::reproject, mark_visible::mark_visible)
                    .after(Core3dSystems::Prepass)
                    .before(Core3dSystems::MainPass),
            )
            .add_systems(
                RenderGraph,
                (
                    draw_sky::draw_sky,
                    draw_tiles::draw_tiles,
                    draw_tiles::draw_light_tiles,
                    (voxelize::voxelize, compact::compact, solve)
                        .chain()
                        .run_if(light_is_computed),
                )
                    .chain()
                    .in_set(RenderGraphSystems::Render)
                    .before(camera_driver),
            );
    }
}

/// Whether the passes have work, or had some in the last frame, so that what they bound is to be released.
fn light_is_computed(plan: Res<FramePlan>, bound: Option<Res<VoxelBindGroups>>) -> bool {
    plan.work.is_some() || bound.is_some()
}

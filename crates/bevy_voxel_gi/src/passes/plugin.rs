//! Registers the passes.

use bevy::{
    core_pipeline::{Core3d, Core3dSystems, schedule::camera_driver},
    prelude::*,
    render::{
        Render, RenderApp, RenderStartup, RenderSystems,
        renderer::{RenderGraph, RenderGraphSystems},
    },
    shader::load_shader_library,
};

use super::{
    bindings::prepare_voxel_bind_groups, compact, gather, inject, propagate, reproject, scroll,
    share, solve::solve, voxelize,
};
use crate::prepare::plan::plan_frame;

/// Registers the passes.
pub(crate) struct PassesPlugin;

impl Plugin for PassesPlugin {
    fn build(&self, app: &mut App) {
        load_shader_library!(app, "bindings.wesl");
        load_shader_library!(app, "voxelize/triangles.wesl");
        scroll::embed(app);
        voxelize::embed(app);
        compact::embed(app);
        inject::embed(app);
        gather::embed(app);
        share::embed(app);
        propagate::embed(app);
        reproject::embed(app);
    }

    fn finish(&self, app: &mut App) {
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        render_app
            .add_systems(
                RenderStartup,
                (
                    scroll::init,
                    voxelize::init,
                    compact::init,
                    inject::init,
                    gather::init,
                    share::init,
                    propagate::init,
                    reproject::init,
                ),
            )
            .add_systems(
                Render,
                (
                    scroll::queue,
                    voxelize::queue,
                    compact::queue,
                    inject::queue,
                    gather::queue,
                    share::queue,
                    propagate::queue,
                    reproject::queue,
                )
                    .in_set(RenderSystems::PrepareResources)
                    .before(plan_frame),
            )
            .add_systems(
                Render,
                (
                    prepare_voxel_bind_groups,
                    scroll::prepare,
                    voxelize::prepare,
                    compact::prepare,
                    inject::prepare,
                    gather::prepare,
                    share::prepare,
                    propagate::prepare,
                )
                    .in_set(RenderSystems::PrepareBindGroups)
                    .after(plan_frame),
            )
            .add_systems(
                Core3d,
                reproject::reproject
                    .after(Core3dSystems::Prepass)
                    .before(Core3dSystems::MainPass),
            )
            .add_systems(
                RenderGraph,
                (scroll::scroll, voxelize::voxelize, compact::compact, solve)
                    .chain()
                    .in_set(RenderGraphSystems::Render)
                    .before(camera_driver),
            );
    }
}

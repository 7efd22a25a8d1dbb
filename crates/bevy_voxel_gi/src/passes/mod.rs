//! The compute passes of a frame, in this order:
//!
//! | pass | what it does |
//! | --- | --- |
//! | [`mod@draw_sky`] | the game's sky to a small map that rays see |
//! | [`draw_tiles`] | textures of materials and lights to the tiles that `tiles.wesl` samples |
//! | [`voxelize`] | meshes to voxels, where something has changed: occupancy; slots for the faces that have a surface (`allocate.wesl`), to which their light moves; surfaces |
//! | [`mod@move_light`] | the light that pixels read, with the levels that have moved |
//! | [`mod@solve`] | lists the surfaces and the empty voxels, and writes what divides new voxels (`compact.wesl`); direct light (`inject.wesl`), then ray tracing and sharing (`gather.wesl`, `share.wesl`) or propagation (`propagate.wesl`) |
//! | [`read_back`] | counts for later frames |
//! | [`cameras`] | from cameras' G-buffers to voxels: albedo (`reproject.wesl`), and what cameras see, for the next frame (`mark_visible.wesl`) |
//!
//! Each has its shaders beside it. [`bindings`] has the resources that they share, [`kernel`] makes their pipelines, and
//! `shaders/` is the shader library.

pub(crate) mod bindings;
mod cameras;
pub(crate) mod draw_sky;
mod draw_tiles;
pub(crate) mod kernel;
mod move_light;
mod solve;
mod voxelize;

use bevy::{
    asset::embedded_asset,
    core_pipeline::{Core3d, Core3dSystems, schedule::camera_driver},
    prelude::*,
    render::{
        GpuResourceAppExt, Render, RenderApp, RenderStartup, RenderSystems,
        renderer::{RenderGraph, RenderGraphSystems},
    },
    shader::load_shader_library,
};

use crate::prepare::{
    buffers::{CountsCopy, read_back},
    plan::{FramePlan, plan_frame},
    tiles::prepare_light_tiles,
};
use bindings::{VoxelBindGroups, prepare_voxel_bind_groups};

/// Registers the passes.
pub(crate) struct PassesPlugin;

impl Plugin for PassesPlugin {
    fn build(&self, app: &mut App) {
        load_shader_library!(app, "bindings.wesl");
        load_shader_library!(app, "tiles.wesl");
        load_shader_library!(app, "voxelize/materials.wesl");
        load_shader_library!(app, "voxelize/polygon.wesl");
        load_shader_library!(app, "voxelize/triangles.wesl");
        embedded_asset!(app, "draw_sky.wesl");
        embedded_asset!(app, "draw_tiles.wesl");
        embedded_asset!(app, "voxelize/scatter.wesl");
        embedded_asset!(app, "voxelize/clear.wesl");
        embedded_asset!(app, "voxelize/cull.wesl");
        embedded_asset!(app, "voxelize/conservative.wesl");
        embedded_asset!(app, "voxelize/slices.wesl");
        embedded_asset!(app, "voxelize/points.wesl");
        embedded_asset!(app, "voxelize/visible.wesl");
        embedded_asset!(app, "voxelize/allocate.wesl");
        embedded_asset!(app, "voxelize/resolve.wesl");
        embedded_asset!(app, "compact.wesl");
        embedded_asset!(app, "inject.wesl");
        embedded_asset!(app, "gather.wesl");
        embedded_asset!(app, "share.wesl");
        embedded_asset!(app, "propagate.wesl");
        embedded_asset!(app, "reproject.wesl");
        embedded_asset!(app, "mark_visible.wesl");
    }

    fn finish(&self, app: &mut App) {
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        render_app
            .init_gpu_resource::<CountsCopy>()
            .init_gpu_resource::<draw_sky::SkyCube>()
            .add_systems(
                RenderStartup,
                (
                    draw_sky::init,
                    draw_tiles::init,
                    voxelize::init,
                    solve::init,
                    cameras::init,
                ),
            )
            .add_systems(
                Render,
                (
                    draw_sky::note_sky,
                    draw_sky::queue.after(draw_sky::note_sky),
                    draw_tiles::queue,
                    voxelize::queue,
                    solve::queue.after(draw_sky::note_sky),
                    cameras::queue,
                )
                    .in_set(RenderSystems::PrepareResources)
                    .after(prepare_light_tiles)
                    .before(plan_frame),
            )
            .add_systems(
                Render,
                (prepare_voxel_bind_groups, voxelize::prepare, solve::prepare)
                    .in_set(RenderSystems::PrepareBindGroups)
                    .after(plan_frame)
                    .run_if(light_is_computed),
            )
            .add_systems(Render, read_back.in_set(RenderSystems::Cleanup))
            .add_systems(
                Core3d,
                cameras::read_g_buffer
                    .after(Core3dSystems::Prepass)
                    .before(Core3dSystems::MainPass),
            )
            .add_systems(
                RenderGraph,
                (
                    draw_sky::draw_sky,
                    draw_tiles::draw_tiles,
                    draw_tiles::draw_light_tiles,
                    (voxelize::voxelize, move_light::move_light, solve::solve)
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

//! Puts the passes into Bevy's renderer.

use bevy::{
    asset::embedded_asset,
    core_pipeline::schedule::{Core3d, Core3dSystems},
    prelude::*,
    render::{
        Render, RenderApp, RenderStartup, RenderSystems, extract_component::ExtractComponentPlugin,
        extract_resource::ExtractResourcePlugin,
    },
    shader::load_shader_library,
};
use bevy_ycocg_fb::YCoCgFrameBufferPlugin;

use super::{
    pass, pipeline,
    settings::{LightAccumulation, LightSources},
    sources::{self, SourcesBuffer},
};

/// Lights the ball for cameras with a [`LightAccumulation`], with the [`LightSources`].
pub struct LightAccumulationPlugin;

impl Plugin for LightAccumulationPlugin {
    fn build(&self, app: &mut App) {
        // For its shader library.
        if !app.is_plugin_added::<YCoCgFrameBufferPlugin>() {
            app.add_plugins(YCoCgFrameBufferPlugin);
        }
        load_shader_library!(app, "surface.wesl");
        load_shader_library!(app, "packing.wesl");
        embedded_asset!(app, "light.wesl");
        embedded_asset!(app, "combine.wesl");
        app.init_resource::<LightSources>().add_plugins((
            ExtractComponentPlugin::<LightAccumulation>::default(),
            ExtractResourcePlugin::<LightSources>::default(),
        ));
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        render_app
            .init_resource::<SourcesBuffer>()
            .add_systems(RenderStartup, pipeline::init)
            .add_systems(
                Render,
                (sources::prepare, pass::prepare_targets).in_set(RenderSystems::PrepareResources),
            )
            .add_systems(
                Core3d,
                pass::accumulate
                    .after(Core3dSystems::MainPass)
                    .before(Core3dSystems::EarlyPostProcess),
            );
    }
}

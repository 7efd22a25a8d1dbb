//! The main pass of a packed camera, and the resolve that ends it.
//!
//! | module | gives |
//! | --- | --- |
//! | [`main_pass`] | opaque, masked, sky, transmissive and transparent, as Bevy draws them |
//! | [`foreign`] | packing twins of pipelines that are no material's, and those that cannot pack |
//! | [`clear`] | the clear colour |
//! | [`resolve`] | from packed texels to colours |
//! | [`hide`] | Bevy's own passes skip packed cameras |

pub(crate) mod clear;
pub(crate) mod foreign;
mod hide;
mod main_pass;
pub(crate) mod resolve;

use bevy::{
    asset::embedded_asset,
    core_pipeline::{
        Core3d, Core3dSystems,
        core_3d::{main_opaque_pass_3d, main_transparent_pass_3d},
    },
    prelude::*,
    render::{
        Render, RenderApp, RenderStartup, RenderSystems,
        render_resource::SpecializedRenderPipelines,
    },
};

/// Draws packed cameras.
pub(crate) struct PackedPassPlugin;

impl Plugin for PackedPassPlugin {
    fn build(&self, app: &mut App) {
        embedded_asset!(app, "clear.wesl");
        embedded_asset!(app, "resolve.wesl");
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        render_app
            .init_resource::<SpecializedRenderPipelines<resolve::ResolvePipeline>>()
            .init_resource::<SpecializedRenderPipelines<clear::ClearPipeline>>()
            .init_resource::<clear::ClearUniforms>()
            .init_resource::<foreign::ForeignPipelines>()
            .init_resource::<hide::HiddenView>()
            .add_systems(
                RenderStartup,
                (resolve::init_pipeline, clear::init_pipeline),
            )
            .add_systems(
                Render,
                (
                    (resolve::prepare_pipelines, clear::prepare)
                        .in_set(RenderSystems::PrepareResources),
                    resolve::prepare_bind_groups.in_set(RenderSystems::PrepareBindGroups),
                ),
            )
            .add_systems(
                Core3d,
                (
                    foreign::pack_foreign_pipelines,
                    main_pass::packed_main_pass,
                    foreign::restore_foreign_pipelines,
                    hide::hide_view,
                )
                    .chain()
                    .before(main_opaque_pass_3d)
                    .in_set(Core3dSystems::MainPass),
            )
            .add_systems(
                Core3d,
                hide::show_view
                    .after(main_transparent_pass_3d)
                    .in_set(Core3dSystems::MainPass),
            );
    }
}

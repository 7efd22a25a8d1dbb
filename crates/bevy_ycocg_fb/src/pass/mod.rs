//! The main pass of a packed camera, and the resolve that ends it.
//!
//! | module | contents |
//! | --- | --- |
//! | [`main_pass`] | opaque, masked, sky, transmissive and transparent phases, in Bevy's order |
//! | [`foreign`] | packing variants of pipelines that do not belong to a material |
//! | [`clear`] | the clear colour |
//! | [`resolve`] | reconstruction of colours from packed texels |
//! | [`hide`] | skipping of Bevy's own main passes for packed cameras |

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

/// Adds the main pass and the resolve of packed cameras.
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

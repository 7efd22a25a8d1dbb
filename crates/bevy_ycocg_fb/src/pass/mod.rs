//! The main pass of a packed camera, the resolve that ends it, and what cameras of all formats need.
//!
//! | module | contents |
//! | --- | --- |
//! | [`main_pass`] | opaque, masked, sky, transmissive and transparent phases, in Bevy's order |
//! | [`phase_pipelines`] | whether the pipelines in the phases write the format, and variants of those that can |
//! | [`classify`] | whether a pipeline writes a format |
//! | [`taa`] | temporal anti-aliasing in `Rg11b10Ufloat` |
//! | [`clear`] | the clear colour |
//! | [`resolve`] | reconstruction of colours from packed texels |

mod classify;
mod clear;
mod main_pass;
mod phase_pipelines;
mod resolve;
pub(crate) mod taa;

use bevy::{
    asset::embedded_asset,
    core_pipeline::{
        Core3d, Core3dSystems,
        core_3d::{
            AlphaMask3d, Opaque3d, Transparent3d, main_opaque_pass_3d, main_transparent_pass_3d,
        },
    },
    pbr::Transmissive3d,
    prelude::*,
    render::{
        Render, RenderApp, RenderStartup, RenderSystems,
        render_resource::SpecializedRenderPipelines,
    },
};

use crate::view::conditions::OwnMainPass;

/// Adds the main pass and the resolve of packed cameras.
pub(crate) struct PackedPassPlugin;

impl Plugin for PackedPassPlugin {
    fn build(&self, app: &mut App) {
        embedded_asset!(app, "clear.wesl");
        embedded_asset!(app, "resolve.wesl");
        app.add_plugins(taa::TaaPlugin);
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        render_app
            .init_resource::<SpecializedRenderPipelines<resolve::ResolvePipeline>>()
            .init_resource::<SpecializedRenderPipelines<clear::ClearPipeline>>()
            .init_resource::<clear::ClearUniforms>()
            .init_resource::<phase_pipelines::PhasePipelines>()
            .init_resource::<phase_pipelines::HiddenBins<Opaque3d>>()
            .init_resource::<phase_pipelines::HiddenBins<AlphaMask3d>>()
            .init_resource::<phase_pipelines::ReplacedItems<Transmissive3d>>()
            .init_resource::<phase_pipelines::ReplacedItems<Transparent3d>>()
            .init_resource::<main_pass::SkippedView>()
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
                    phase_pipelines::inspect_phases
                        .after(RenderSystems::PhaseSort)
                        .before(RenderSystems::Prepare),
                    (
                        phase_pipelines::inspect_skyboxes,
                        main_pass::wait_for_pipelines,
                    )
                        .chain()
                        .after(RenderSystems::Prepare)
                        .before(RenderSystems::Render),
                    phase_pipelines::restore_phases.in_set(RenderSystems::Cleanup),
                ),
            )
            .add_systems(
                Core3d,
                (main_pass::packed_main_pass, main_pass::skip_main_passes)
                    .chain()
                    .before(main_opaque_pass_3d)
                    .in_set(OwnMainPass)
                    .in_set(Core3dSystems::MainPass),
            )
            .add_systems(
                Core3d,
                main_pass::restore_current_view
                    .after(main_transparent_pass_3d)
                    .in_set(OwnMainPass)
                    .in_set(Core3dSystems::MainPass),
            );
    }
}

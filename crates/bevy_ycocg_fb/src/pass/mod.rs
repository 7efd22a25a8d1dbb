//! The main pass of a packed camera, the resolve that ends it, and what cameras of all formats need.
//!
//! | module | contents |
//! | --- | --- |
//! | [`main_pass`] | the clear colour, and opaque, masked, sky, transmissive and transparent phases, in Bevy's order |
//! | [`phase_pipelines`] | whether the pipelines in the phases write the format, and variants of those that can |
//! | [`taa`] | temporal anti-aliasing in `Rg11b10Ufloat` |
//! | [`resolve`] | reconstruction of colours from packed texels |

pub(crate) mod main_pass;
mod phase_pipelines;
pub(crate) mod resolve;
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
        camera::ExtractedCamera,
        diagnostic::RecordDiagnostics,
        render_resource::{
            BindGroup, RenderPassColorAttachment, RenderPassDescriptor, RenderPipeline,
            SpecializedRenderPipelines,
        },
        renderer::RenderContext,
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
            .init_resource::<SpecializedRenderPipelines<main_pass::ClearPipeline>>()
            .init_resource::<main_pass::ClearUniforms>()
            .init_resource::<phase_pipelines::PhasePipelines>()
            .init_resource::<phase_pipelines::HiddenBins<Opaque3d>>()
            .init_resource::<phase_pipelines::HiddenBins<AlphaMask3d>>()
            .init_resource::<phase_pipelines::ReplacedItems<Transmissive3d>>()
            .init_resource::<phase_pipelines::ReplacedItems<Transparent3d>>()
            .init_resource::<main_pass::SkippedView>()
            .add_systems(
                RenderStartup,
                (resolve::init_pipeline, main_pass::init_clear_pipeline),
            )
            .add_systems(
                Render,
                (
                    (resolve::prepare_pipelines, main_pass::prepare_clear)
                        .in_set(RenderSystems::PrepareResources),
                    resolve::prepare_bind_groups.in_set(RenderSystems::PrepareBindGroups),
                    // The first reason for which a camera cannot draw is the one that it reports.
                    (
                        phase_pipelines::begin_inspection,
                        phase_pipelines::inspect_bins::<Opaque3d>,
                        phase_pipelines::inspect_bins::<AlphaMask3d>,
                        phase_pipelines::inspect_items::<Transmissive3d>,
                        phase_pipelines::inspect_items::<Transparent3d>,
                    )
                        .chain()
                        .after(RenderSystems::PhaseSort)
                        .before(RenderSystems::Prepare),
                    (
                        phase_pipelines::inspect_skyboxes,
                        main_pass::wait_for_pipelines,
                    )
                        .chain()
                        .after(RenderSystems::Prepare)
                        .before(RenderSystems::Render),
                    (
                        phase_pipelines::restore_bins::<Opaque3d>,
                        phase_pipelines::restore_bins::<AlphaMask3d>,
                        phase_pipelines::restore_items::<Transmissive3d>,
                        phase_pipelines::restore_items::<Transparent3d>,
                    )
                        .in_set(RenderSystems::Cleanup),
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

/// Draws a full-screen triangle into the viewport of a camera, in a pass of its own; nothing while there is no pipeline.
fn draw_fullscreen(
    ctx: &mut RenderContext,
    label: &'static str,
    color_attachments: &[Option<RenderPassColorAttachment>],
    camera: &ExtractedCamera,
    pipeline: Option<&RenderPipeline>,
    bind_group: &BindGroup,
    dynamic_offsets: &[u32],
) {
    let diagnostics = ctx.diagnostic_recorder();
    let diagnostics = diagnostics.as_deref();
    let mut pass = ctx.begin_tracked_render_pass(RenderPassDescriptor {
        label: Some(label),
        color_attachments,
        ..default()
    });
    let span = diagnostics.pass_span(&mut pass, label);
    if let Some(pipeline) = pipeline {
        if let Some(viewport) = &camera.viewport {
            pass.set_camera_viewport(viewport);
        }
        pass.set_render_pipeline(pipeline);
        pass.set_bind_group(0, bind_group, dynamic_offsets);
        pass.draw(0..3, 0..1);
    }
    span.end(&mut pass);
}

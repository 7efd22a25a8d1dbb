//! The choice of the cameras that use their format, and the preparation of their views.
//!
//! | module | contents |
//! | --- | --- |
//! | [`candidate`] | the cameras, with what decides about them |
//! | [`stack`] | the cameras that share a picture |
//! | [`main_pass_systems`] | the systems of other plugins in the main pass |
//! | [`refusals`] | the formats that drawing a camera has shown to be impossible |
//! | [`net`] | what happens when the renderer refuses a frame |
//! | [`eligibility`] | the choice of the cameras that use another format |
//! | [`packed`] | the cameras that pack |
//! | [`rg11b10ufloat`] | the cameras that Bevy draws in `Rg11b10Ufloat` |
//! | [`format`](mod@format) | the target format in Bevy's pipeline keys and phases |
//! | [`msaa`] | a single-sampled `ViewTarget` beside multisampled packed textures |
//! | [`textures`] | the packed textures |
//! | [`capabilities`] | the adapter's support of the formats |

mod candidate;
pub(crate) mod capabilities;
pub(crate) mod eligibility;
mod format;
pub(crate) mod main_pass_systems;
mod msaa;
mod net;
pub(crate) mod packed;
pub(crate) mod refusals;
pub(crate) mod rg11b10ufloat;
mod stack;
pub(crate) mod textures;

use bevy::{
    pbr::check_views_need_specialization,
    prelude::*,
    render::{ExtractSchedule, Render, RenderApp, RenderSystems, view::prepare_view_targets},
};

use crate::report::{FrameBufferReport, RenderedReports};

/// Chooses the cameras that use their format and prepares them.
pub(crate) struct PackedViewPlugin;

impl Plugin for PackedViewPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(
            First,
            net::install.run_if(any_with_component::<FrameBufferReport>),
        );
        let reports = app.world().resource::<RenderedReports>().clone();
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        render_app
            .insert_resource(reports)
            .init_resource::<candidate::MainWorldState>()
            .init_resource::<main_pass_systems::MainPassSystems>()
            .init_resource::<refusals::Refusals>()
            .init_resource::<eligibility::Decisions>()
            .init_resource::<eligibility::SwitchedViews>()
            .init_resource::<format::OriginalFormats>()
            .init_resource::<msaa::OriginalMsaa>()
            .add_systems(
                ExtractSchedule,
                (
                    candidate::extract_main_world_state,
                    candidate::extract_qualities,
                ),
            )
            .add_systems(
                Render,
                (
                    (
                        main_pass_systems::find_main_pass_systems
                            .run_if(any_with_component::<crate::settings::FrameBufferQuality>),
                        eligibility::select_views,
                        rg11b10ufloat::set_formats,
                    )
                        .chain()
                        .after(RenderSystems::ExtractCommands)
                        .before(RenderSystems::PrepareAssets),
                    // The packed format is visible only while pipeline keys are made and phases are
                    // queued.
                    (
                        (format::set_packed_formats, format::unmark_keys)
                            .before(check_views_need_specialization),
                        (format::restore_formats, format::mark_keys)
                            .after(check_views_need_specialization),
                    )
                        .in_set(RenderSystems::PrepareAssets),
                    format::set_packed_formats
                        .after(RenderSystems::PrepareViews)
                        .before(RenderSystems::Queue),
                    format::restore_formats
                        .after(RenderSystems::PhaseSort)
                        .before(RenderSystems::Prepare),
                    (
                        msaa::disable_msaa.before(prepare_view_targets),
                        msaa::restore_msaa.after(prepare_view_targets),
                    )
                        .in_set(RenderSystems::PrepareViews),
                    textures::prepare_textures.in_set(RenderSystems::PrepareResources),
                    textures::replace_transmission_textures
                        .after(RenderSystems::PrepareResources)
                        .before(RenderSystems::PrepareBindGroups),
                    textures::publish_reports.in_set(RenderSystems::PrepareBindGroups),
                ),
            );
    }
}

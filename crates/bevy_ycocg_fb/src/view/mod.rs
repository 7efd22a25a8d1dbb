//! The choice of the cameras that use their format, and the preparation of their views.
//!
//! | module | contents |
//! | --- | --- |
//! | [`conditions`] | what decides whether a camera can use a format, and what has shown that it cannot |
//! | [`eligibility`] | the choice of the cameras that use another format, beside those that share their picture; its report |
//! | [`formatted`] | the views with another format, what Bevy sees of them, and the packed textures |

pub(crate) mod conditions;
pub(crate) mod eligibility;
pub(crate) mod formatted;

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
            conditions::install_error_handler.run_if(any_with_component::<FrameBufferReport>),
        );
        let reports = app.world().resource::<RenderedReports>().clone();
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        render_app
            .insert_resource(reports)
            .init_resource::<conditions::MainWorldState>()
            .init_resource::<conditions::MainPassSystems>()
            .init_resource::<conditions::Refusals>()
            .init_resource::<eligibility::Decisions>()
            .init_resource::<eligibility::SwitchedViews>()
            .init_resource::<formatted::OriginalFormats>()
            .init_resource::<formatted::OriginalMsaa>()
            .add_systems(
                ExtractSchedule,
                (
                    conditions::extract_main_world_state,
                    conditions::extract_qualities,
                ),
            )
            .add_systems(
                Render,
                (
                    (
                        conditions::find_main_pass_systems
                            .run_if(any_with_component::<crate::settings::FrameBufferQuality>),
                        eligibility::select_views,
                        formatted::set_rg11b10ufloat_formats,
                    )
                        .chain()
                        .after(RenderSystems::ExtractCommands)
                        .before(RenderSystems::PrepareAssets),
                    // The packed format is visible only while pipeline keys are made and phases are
                    // queued.
                    (
                        (formatted::set_packed_formats, formatted::unmark_keys)
                            .before(check_views_need_specialization),
                        (formatted::restore_formats, formatted::mark_keys)
                            .after(check_views_need_specialization),
                    )
                        .in_set(RenderSystems::PrepareAssets),
                    formatted::set_packed_formats
                        .after(RenderSystems::PrepareViews)
                        .before(RenderSystems::Queue),
                    formatted::restore_formats
                        .after(RenderSystems::PhaseSort)
                        .before(RenderSystems::Prepare),
                    (
                        formatted::disable_msaa.before(prepare_view_targets),
                        formatted::restore_msaa.after(prepare_view_targets),
                    )
                        .in_set(RenderSystems::PrepareViews),
                    formatted::prepare_textures.in_set(RenderSystems::PrepareResources),
                    formatted::replace_transmission_textures
                        .after(RenderSystems::PrepareResources)
                        .before(RenderSystems::PrepareBindGroups),
                    eligibility::publish_reports.in_set(RenderSystems::PrepareBindGroups),
                ),
            );
    }
}

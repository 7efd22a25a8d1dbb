//! The choice of the cameras that pack, and the preparation of their views.
//!
//! | module | contents |
//! | --- | --- |
//! | [`eligibility`] | the choice of the cameras that pack |
//! | [`fallback`] | the reasons for which the others do not |
//! | [`format`](mod@format) | the target format in Bevy's pipeline keys and phases |
//! | [`msaa`] | a single-sampled `ViewTarget` beside multisampled packed textures |
//! | [`textures`] | the packed textures |
//! | [`capabilities`] | the adapter's support of the packed formats |

pub(crate) mod capabilities;
pub(crate) mod eligibility;
pub mod fallback;
mod format;
mod msaa;
pub(crate) mod textures;

use bevy::{
    pbr::check_views_need_specialization,
    prelude::*,
    render::{ExtractSchedule, Render, RenderApp, RenderSystems, view::prepare_view_targets},
};

use crate::report::FrameBufferReports;
use eligibility::{UnpackedPipelines, WarnedOf};

/// Chooses the cameras that pack and prepares them.
pub(crate) struct PackedViewPlugin;

impl Plugin for PackedViewPlugin {
    fn build(&self, app: &mut App) {
        let reports = FrameBufferReports::default();
        app.insert_resource(reports.clone());
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        render_app
            .insert_resource(reports)
            .init_resource::<eligibility::MainWorldState>()
            .init_resource::<UnpackedPipelines>()
            .init_resource::<WarnedOf>()
            .init_resource::<format::OwnFormats>()
            .init_resource::<msaa::HiddenMsaa>()
            .add_systems(ExtractSchedule, eligibility::extract_main_world_state)
            .add_systems(
                Render,
                (
                    eligibility::choose_views
                        .after(RenderSystems::ExtractCommands)
                        .before(RenderSystems::PrepareAssets),
                    // The packed format is visible only while pipeline keys are made and phases are
                    // queued.
                    (
                        (format::show_packed, format::unmark_keys)
                            .before(check_views_need_specialization),
                        (format::restore, format::mark_keys).after(check_views_need_specialization),
                    )
                        .in_set(RenderSystems::PrepareAssets),
                    format::show_packed
                        .after(RenderSystems::PrepareViews)
                        .before(RenderSystems::Queue),
                    format::restore
                        .after(RenderSystems::PhaseSort)
                        .before(RenderSystems::Prepare),
                    (
                        msaa::hide.before(prepare_view_targets),
                        msaa::restore.after(prepare_view_targets),
                    )
                        .in_set(RenderSystems::PrepareViews),
                    textures::prepare_textures.in_set(RenderSystems::PrepareResources),
                    textures::replace_transmission_textures
                        .after(RenderSystems::PrepareResources)
                        .before(RenderSystems::PrepareBindGroups),
                    textures::report_memory.in_set(RenderSystems::PrepareBindGroups),
                ),
            );
    }
}

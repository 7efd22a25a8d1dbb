//! Wireframes of views whose layout changes.
//!
//! Bevy 0.20 specializes the pipelines of wireframes anew when a mesh or its wireframe changes, but not when a
//! view does, as it does for materials: where a view gets an irradiance volume or another format later than its
//! wireframes, they are drawn by pipelines that do not fit its bind group, which ends the app.

use bevy::{
    pbr::check_views_need_specialization,
    prelude::*,
    render::{
        Render, RenderApp, RenderSystems,
        camera::{DirtySpecializations, DirtyWireframeSpecializations},
    },
};

/// Specializes wireframes anew where the materials of a view are. Plugins that change views while the app runs
/// add it, unless it has been added.
#[derive(Clone, Copy, Debug, Default)]
pub struct ViewWireframesPlugin;

impl Plugin for ViewWireframesPlugin {
    fn build(&self, app: &mut App) {
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        render_app.add_systems(
            Render,
            mark_wireframes_of_changed_views
                .after(check_views_need_specialization)
                .in_set(RenderSystems::PrepareAssets),
        );
    }
}

fn mark_wireframes_of_changed_views(
    materials: Res<DirtySpecializations>,
    mut wireframes: ResMut<DirtyWireframeSpecializations>,
) {
    wireframes.views.extend(&materials.views);
}

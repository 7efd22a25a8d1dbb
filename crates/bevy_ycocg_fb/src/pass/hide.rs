//! Bevy's own main passes skip packed cameras.
//!
//! A pass is a system that queries the components of the current view and is skipped where there
//! are none. So the current view is set to a placeholder from the end of the packed main pass to the end
//! of Bevy's main passes.

use bevy::{prelude::*, render::renderer::CurrentView};

use crate::view::eligibility::PackedView;

/// The current view while it is hidden.
#[derive(Resource, Default)]
pub(super) struct HiddenView(Option<Entity>);

pub(super) fn hide_view(
    current: Option<ResMut<CurrentView>>,
    mut hidden: ResMut<HiddenView>,
    packed: Query<(), With<PackedView>>,
) {
    if let Some(mut current) = current
        && packed.contains(current.0)
    {
        hidden.0 = Some(current.0);
        current.0 = Entity::PLACEHOLDER;
    }
}

pub(super) fn show_view(current: Option<ResMut<CurrentView>>, mut hidden: ResMut<HiddenView>) {
    if let Some(mut current) = current
        && let Some(entity) = hidden.0.take()
    {
        current.0 = entity;
    }
}

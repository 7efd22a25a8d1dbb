//! Bevy's own passes skip packed cameras.
//!
//! A pass is a system that asks for the components of the current view and is skipped where there
//! are none: between our pass and the end of Bevy's there is no current view.

use bevy::{prelude::*, render::renderer::CurrentView};

use crate::view::eligibility::PackedView;

/// The view that was hidden.
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

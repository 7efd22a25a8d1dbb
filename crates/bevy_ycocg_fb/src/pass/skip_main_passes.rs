//! Bevy's own main passes skip packed cameras.
//!
//! A pass is a system that queries the components of the current view and is skipped where there
//! are none. So the current view is set to a placeholder from the end of the packed main pass to the end
//! of Bevy's main passes.

use bevy::{prelude::*, render::renderer::CurrentView};

use crate::view::packed::PackedView;

/// The packed view that Bevy's main passes skip.
#[derive(Resource, Default)]
pub(super) struct SkippedView(Option<Entity>);

pub(super) fn skip_main_passes(
    current: Option<ResMut<CurrentView>>,
    mut skipped: ResMut<SkippedView>,
    packed: Query<(), With<PackedView>>,
) {
    if let Some(mut current) = current
        && packed.contains(current.0)
    {
        skipped.0 = Some(current.0);
        current.0 = Entity::PLACEHOLDER;
    }
}

pub(super) fn restore_current_view(
    current: Option<ResMut<CurrentView>>,
    mut skipped: ResMut<SkippedView>,
) {
    if let Some(mut current) = current
        && let Some(entity) = skipped.0.take()
    {
        current.0 = entity;
    }
}

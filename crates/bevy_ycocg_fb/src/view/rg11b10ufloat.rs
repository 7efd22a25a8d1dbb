//! The cameras that Bevy draws in `Rg11b10Ufloat`.
//!
//! All of Bevy's passes and textures take their format from the view, so nothing else is replaced but the pass of
//! temporal anti-aliasing ([`taa`](crate::pass::taa)), whose history needs an alpha channel.

use bevy::{
    ecs::entity::EntityHashSet,
    prelude::*,
    render::{
        render_resource::{TextureFormat, TextureUsages},
        sync_world::MainEntity,
        view::ExtractedView,
    },
};

use super::candidate::CandidateItem;
use crate::fallback::FallbackReason;

/// Component of a view that Bevy draws in `Rg11b10Ufloat`.
#[derive(Component, Clone, Copy, Debug)]
pub(crate) struct Rg11b10UfloatView;

/// The last of the subviews of a camera that take their format from its own: that of Bevy's user interface.
const LAST_SUBVIEW: u32 = 1;

/// Returns the first reason for which the camera alone cannot be drawn in `Rg11b10Ufloat`.
pub(super) fn rg11b10ufloat_reason(
    candidate: &CandidateItem,
    views: &Query<&ExtractedView>,
) -> Option<FallbackReason> {
    let drawn_over = views.iter().any(|view| {
        view.retained_view_entity.main_entity == *candidate.main_entity
            && view.retained_view_entity.subview_index > LAST_SUBVIEW
    });
    let has_storage = candidate.usages.0.contains(TextureUsages::STORAGE_BINDING);
    if drawn_over {
        Some(FallbackReason::DrawnOver)
    } else if has_storage {
        Some(FallbackReason::StorageUsage)
    } else {
        None
    }
}

/// Replaces the format of the views, which Bevy extracts anew in every frame, and of those of the user interface
/// over them.
pub(super) fn set_formats(
    cameras: Query<&MainEntity, With<Rg11b10UfloatView>>,
    mut views: Query<&mut ExtractedView>,
) {
    if cameras.is_empty() {
        return;
    }
    let cameras: EntityHashSet = cameras.iter().map(MainEntity::id).collect();
    for mut view in &mut views {
        if cameras.contains(&view.retained_view_entity.main_entity.id()) {
            view.target_format = TextureFormat::Rg11b10Ufloat;
        }
    }
}

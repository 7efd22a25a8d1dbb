//! The target format of views in Bevy's pipeline keys and phases.
//!
//! `ViewTarget` and all effects keep the format of the camera. While mesh pipeline keys are made and
//! phases are queued, a packed view has the format of its packed texture. Its key has a flag, so that it differs
//! from a view whose target happens to have that format, and so has that of a view in `Rg11b10Ufloat`.

use bevy::{
    ecs::entity::EntityHashMap,
    pbr::{MeshPipelineKey, ViewKeyCache},
    prelude::*,
    render::{render_resource::TextureFormat, view::ExtractedView},
};

use super::{eligibility::Formatted, packed::PackedView};
use crate::material::pipeline::PACKED_KEY;

/// The original formats of the views while they are replaced.
#[derive(Resource, Default)]
pub(super) struct OriginalFormats(EntityHashMap<TextureFormat>);

pub(super) fn set_packed_formats(
    mut views: Query<(Entity, &mut ExtractedView, &PackedView)>,
    mut original: ResMut<OriginalFormats>,
) {
    for (entity, mut view, packed) in &mut views {
        original.0.insert(entity, view.target_format);
        view.target_format = packed.format.texture_format();
    }
}

pub(super) fn restore_formats(
    mut views: Query<&mut ExtractedView>,
    mut original: ResMut<OriginalFormats>,
) {
    for (entity, format) in original.0.drain() {
        if let Ok(mut view) = views.get_mut(entity) {
            view.target_format = format;
        }
    }
}

/// Sets the flag in the keys of views with another format.
pub(super) fn mark_keys(
    views: Query<&ExtractedView, Formatted>,
    keys: Option<ResMut<ViewKeyCache>>,
) {
    let Some(mut keys) = keys else {
        return;
    };
    for view in &views {
        if let Some(key) = keys.get_mut(&view.retained_view_entity) {
            *key |= MeshPipelineKey::from_bits_retain(PACKED_KEY);
        }
    }
}

/// Removes the flag before Bevy compares the keys with those of this frame: if they differed, Bevy would
/// specialize all pipelines again.
pub(super) fn unmark_keys(keys: Option<ResMut<ViewKeyCache>>) {
    for key in keys
        .into_iter()
        .flat_map(|keys| keys.into_inner().values_mut())
    {
        *key = MeshPipelineKey::from_bits_retain(key.bits() & !PACKED_KEY);
    }
}

//! The format that Bevy takes a view to have.
//!
//! `ViewTarget` and all effects keep the format of the camera. Meshes are keyed by a stand-in for
//! the packed format (see `PackedFormat::key_format`), and what is queued into the phases finds
//! the packed format itself, so that even a pipeline that does not pack fits the pass.

use bevy::{
    ecs::entity::EntityHashMap, prelude::*, render::render_resource::TextureFormat,
    render::view::ExtractedView,
};

use super::eligibility::PackedView;

/// The formats that were replaced.
#[derive(Resource, Default)]
pub(super) struct OwnFormats(EntityHashMap<TextureFormat>);

type PackedViews<'w, 's> = Query<'w, 's, (Entity, &'static mut ExtractedView, &'static PackedView)>;

pub(super) fn show_key_format(views: PackedViews, own: ResMut<OwnFormats>) {
    show(views, own, |packed| packed.settings.format.key_format());
}

pub(super) fn show_packed_format(views: PackedViews, own: ResMut<OwnFormats>) {
    show(views, own, |packed| packed.settings.format.texture_format());
}

fn show(
    mut views: PackedViews,
    mut own: ResMut<OwnFormats>,
    format: impl Fn(&PackedView) -> TextureFormat,
) {
    for (entity, mut view, packed) in &mut views {
        own.0.insert(entity, view.target_format);
        view.target_format = format(packed);
    }
}

pub(super) fn restore(mut views: Query<&mut ExtractedView>, mut own: ResMut<OwnFormats>) {
    for (entity, format) in own.0.drain() {
        if let Ok(mut view) = views.get_mut(entity) {
            view.target_format = format;
        }
    }
}

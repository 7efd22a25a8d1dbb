//! A single-sampled `ViewTarget` for packed views, because only the packed texture is multisampled.

use bevy::{
    camera::MsaaWriteback,
    ecs::entity::EntityHashMap,
    prelude::*,
    render::{camera::ExtractedCamera, view::Msaa},
};

use super::packed::PackedView;

/// The original sample counts of the views while they are replaced.
#[derive(Resource, Default)]
pub(super) struct OriginalMsaa(EntityHashMap<Msaa>);

pub(super) fn disable_msaa(
    mut views: Query<(Entity, &mut Msaa, &mut ExtractedCamera), With<PackedView>>,
    mut original: ResMut<OriginalMsaa>,
) {
    for (entity, mut msaa, mut camera) in &mut views {
        original.0.insert(entity, *msaa);
        *msaa = Msaa::Off;
        // The view has no multisampled texture to write back to.
        camera.msaa_writeback = MsaaWriteback::Off;
    }
}

pub(super) fn restore_msaa(mut views: Query<&mut Msaa>, mut original: ResMut<OriginalMsaa>) {
    for (entity, samples) in original.0.drain() {
        if let Ok(mut msaa) = views.get_mut(entity) {
            *msaa = samples;
        }
    }
}

//! A single-sampled `ViewTarget`: the samples are those of the packed texture.

use bevy::{
    camera::MsaaWriteback,
    ecs::entity::EntityHashMap,
    prelude::*,
    render::{camera::ExtractedCamera, view::Msaa},
};

use super::eligibility::PackedView;

/// The sample counts that were hidden.
#[derive(Resource, Default)]
pub(super) struct HiddenMsaa(EntityHashMap<Msaa>);

pub(super) fn hide(
    mut views: Query<(Entity, &mut Msaa, &mut ExtractedCamera), With<PackedView>>,
    mut hidden: ResMut<HiddenMsaa>,
) {
    for (entity, mut msaa, mut camera) in &mut views {
        hidden.0.insert(entity, *msaa);
        *msaa = Msaa::Off;
        // There is nothing multisampled to write back to.
        camera.msaa_writeback = MsaaWriteback::Off;
    }
}

pub(super) fn restore(mut views: Query<&mut Msaa>, mut hidden: ResMut<HiddenMsaa>) {
    for (entity, samples) in hidden.0.drain() {
        if let Ok(mut msaa) = views.get_mut(entity) {
            *msaa = samples;
        }
    }
}

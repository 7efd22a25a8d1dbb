//! Extracts the active volumes.

use bevy::{prelude::*, render::Extract};

use super::{
    lights::ExtractedLights, meshes::ExtractedScene, place_volume::ActiveVolume,
    placement::PlacedVolume,
};

/// The active volumes of this frame, if there are any.
#[derive(Resource, Default)]
pub(crate) struct ExtractedVolume(pub Option<PlacedVolume>);

/// Extracts them; where there is none, forgets the scene, whose changes are not followed then.
pub(crate) fn extract_volume(
    mut volume: ResMut<ExtractedVolume>,
    active: Extract<Res<ActiveVolume>>,
    (mut scene, mut lights): (ResMut<ExtractedScene>, ResMut<ExtractedLights>),
) {
    if volume.0.is_some() && active.volume.is_none() {
        *scene = default();
        *lights = default();
    }
    volume.0.clone_from(&active.volume);
}

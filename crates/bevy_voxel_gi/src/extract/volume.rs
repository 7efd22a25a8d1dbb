//! Extracts the active volumes.

use bevy::{prelude::*, render::Extract};

use super::{place_volume::ActiveVolume, placement::PlacedVolume};

/// The active volumes of this frame, if there are any.
#[derive(Resource, Default)]
pub(crate) struct ExtractedVolume(pub Option<PlacedVolume>);

pub(crate) fn extract_volume(
    mut volume: ResMut<ExtractedVolume>,
    active: Extract<Res<ActiveVolume>>,
) {
    volume.0.clone_from(&active.volume);
}

//! Preparation of an unchanged asset once more.

use bevy::prelude::*;

/// Marks an asset as modified, so that the renderer prepares it again.
pub(crate) fn mark_modified<A: Asset>(assets: &mut Assets<A>, id: AssetId<A>) {
    if let Some(mut asset) = assets.get_mut(id) {
        // Only a mutable reference marks the asset as modified.
        let _: &mut A = &mut asset;
    }
}

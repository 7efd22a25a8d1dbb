//! Updates materials when their textures are reloaded.

use bevy::{
    asset::{AssetEvent, AssetId, Assets},
    ecs::{
        message::MessageReader,
        system::{Local, ResMut},
    },
};

use super::extension::WaveletStandardMaterial;
use crate::asset::WaveletTexture;

/// Marks materials as changed when one of their textures is, so that they are bound again: in that
/// frame and in the next, since a frame can prepare a material before its texture.
pub(crate) fn rebind_materials(
    mut events: MessageReader<AssetEvent<WaveletTexture>>,
    mut again: Local<Vec<AssetId<WaveletStandardMaterial>>>,
    mut materials: ResMut<Assets<WaveletStandardMaterial>>,
) {
    let mut due = std::mem::take(&mut *again);
    let changed: Vec<AssetId<WaveletTexture>> = events
        .read()
        .filter_map(|event| match event {
            AssetEvent::Modified { id } => Some(*id),
            _ => None,
        })
        .collect();
    if !changed.is_empty() {
        for (id, material) in materials.iter() {
            let mut textures = material.extension.textures();
            if textures.any(|texture| changed.contains(&texture.id())) {
                again.push(id);
            }
        }
    }
    due.extend(&*again);
    for id in due {
        // Only access through `DerefMut` marks the material as changed.
        if let Some(mut material) = materials.get_mut(id) {
            let _: &mut WaveletStandardMaterial = &mut material;
        }
    }
}

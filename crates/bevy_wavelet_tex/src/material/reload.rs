//! Keeps the forms of textures in materials up to date, by which their pipelines are specialised.

use bevy::{
    asset::{AssetEvent, AssetId, Assets},
    ecs::{
        message::MessageReader,
        system::{Local, Res, ResMut},
    },
};

use super::extension::WaveletStandardMaterial;
use crate::asset::WaveletTexture;

/// Marks materials as changed when one of their textures is loaded or changed, so that they are bound
/// again: in that frame and in the next, since a frame can prepare a material before its texture.
pub(crate) fn rebind_materials(
    mut events: MessageReader<AssetEvent<WaveletTexture>>,
    mut again: Local<Vec<AssetId<WaveletStandardMaterial>>>,
    mut materials: ResMut<Assets<WaveletStandardMaterial>>,
) {
    let mut due = std::mem::take(&mut *again);
    let changed: Vec<AssetId<WaveletTexture>> = events
        .read()
        .filter_map(|event| match event {
            AssetEvent::Added { id } | AssetEvent::Modified { id } => Some(*id),
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

/// Writes the forms of their textures into the materials that are new or changed, after their events
/// and before they are extracted.
pub(crate) fn write_forms(
    mut events: MessageReader<AssetEvent<WaveletStandardMaterial>>,
    textures: Res<Assets<WaveletTexture>>,
    mut materials: ResMut<Assets<WaveletStandardMaterial>>,
) {
    for event in events.read() {
        if let AssetEvent::Added { id } | AssetEvent::Modified { id } = event
            && let Some(material) = materials.get_mut_untracked(*id)
        {
            material.extension.forms = material.extension.current_forms(&textures);
        }
    }
}

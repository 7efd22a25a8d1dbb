//! Keeps up to date in materials what their pipelines are specialised by: the forms of textures, and whether the scene
//! has decals.

use bevy::{
    asset::{AssetEvent, AssetId, Assets},
    ecs::{
        message::MessageReader,
        query::With,
        resource::Resource,
        system::{Local, Query, Res, ResMut},
    },
    light::ClusteredDecal,
};
use bevy_frugal_hooks::MaterialImages;

use super::extension::WaveletStandardMaterial;
use crate::asset::WaveletTexture;

/// Whether the scene has had clustered decals, for which materials have code from then on.
#[derive(Resource, Default)]
pub(crate) struct Decals(bool);

/// Marks all materials as changed when the first clustered decal comes.
pub(crate) fn find_decals(
    mut found: ResMut<Decals>,
    decals: Query<(), With<ClusteredDecal>>,
    mut materials: ResMut<Assets<WaveletStandardMaterial>>,
) {
    if !found.0 && !decals.is_empty() {
        found.0 = true;
        materials.iter_mut().for_each(drop);
    }
}

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
/// and before they are extracted; and their images, where a plugin reads them.
pub(crate) fn write_forms(
    mut events: MessageReader<AssetEvent<WaveletStandardMaterial>>,
    textures: Res<Assets<WaveletTexture>>,
    decals: Res<Decals>,
    mut materials: ResMut<Assets<WaveletStandardMaterial>>,
    mut images: Option<ResMut<MaterialImages>>,
) {
    for event in events.read() {
        match event {
            AssetEvent::Added { id } | AssetEvent::Modified { id } => {
                let Some(material) = materials.get_mut_untracked(*id) else {
                    continue;
                };
                let WaveletStandardMaterial { base, extension } = &mut *material;
                extension.update_forms(base, &textures, decals.0);
                if let Some(images) = &mut images {
                    let previews = extension.previews(base, &textures);
                    images.0.insert(id.untyped(), previews);
                }
            }
            AssetEvent::Removed { id } => {
                if let Some(images) = &mut images {
                    images.0.remove(&id.untyped());
                }
            }
            _ => {}
        }
    }
}

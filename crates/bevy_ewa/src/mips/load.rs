//! Generates mip chains for the textures of materials as they are loaded.
//!
//! Only textures that a filtered material uses get a mip chain; all others stay unchanged, byte for
//! byte. The renderer takes the texels of an image in the frame in which it is added, so they are cloned
//! before that and kept for a while in case a material that uses them is added later.

use bevy::{
    asset::AssetEventSystems,
    platform::collections::HashMap,
    prelude::*,
    tasks::{AsyncComputeTaskPool, Task, block_on, futures_lite::future},
};

use super::{
    chain::{MipChain, generate_mip_chain},
    lacking::{lacks_mips, texel_format},
};
use crate::material::{
    AllMaterials, EwaStandardMaterial, maps::maps, mark_modified::mark_modified,
};

/// Number of frames for which the texels of an image are kept for a material that may be added later.
const FRAMES_KEPT: u32 = 300;

/// Generates the mip chains of textures that filtered materials use.
pub(crate) struct MipLoadPlugin;

impl Plugin for MipLoadPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<MipGeneration>().add_systems(
            PostUpdate,
            (find_textures, find_images, start_tasks, finish_tasks)
                .chain()
                .after(AssetEventSystems),
        );
    }
}

#[derive(Resource, Default)]
struct MipGeneration {
    /// Textures of filtered materials, with true for normal maps.
    used_textures: HashMap<AssetId<Image>, bool>,
    /// Images without mip levels, whose texels the renderer is about to take.
    candidates: HashMap<AssetId<Image>, Candidate>,
    tasks: HashMap<AssetId<Image>, (Image, Task<Option<MipChain>>)>,
}

struct Candidate {
    image: Image,
    frames_left: u32,
}

fn find_textures(
    mut mips: ResMut<MipGeneration>,
    all: Res<AllMaterials>,
    standard: Res<Assets<StandardMaterial>>,
    extended: Res<Assets<EwaStandardMaterial>>,
    mut standard_events: MessageReader<AssetEvent<StandardMaterial>>,
    mut extended_events: MessageReader<AssetEvent<EwaStandardMaterial>>,
) {
    let mut add_textures = |material: &StandardMaterial| {
        for map in maps(material) {
            let known = mips.used_textures.entry(map.texture.id()).or_default();
            *known |= map.has_normals();
        }
    };
    if all.is_changed() && all.0.is_some() {
        standard
            .iter()
            .for_each(|(_, material)| add_textures(material));
    }
    for event in standard_events.read() {
        if let AssetEvent::Added { id } | AssetEvent::Modified { id } = event
            && all.0.is_some()
            && let Some(material) = standard.get(*id)
        {
            add_textures(material);
        }
    }
    for event in extended_events.read() {
        if let AssetEvent::Added { id } | AssetEvent::Modified { id } = event
            && let Some(material) = extended.get(*id)
        {
            add_textures(&material.base);
        }
    }
}

fn find_images(
    mut mips: ResMut<MipGeneration>,
    images: Res<Assets<Image>>,
    mut events: MessageReader<AssetEvent<Image>>,
) {
    mips.candidates.retain(|_, candidate| {
        candidate.frames_left -= 1;
        candidate.frames_left > 0
    });
    for event in events.read() {
        match event {
            AssetEvent::Added { id } | AssetEvent::Modified { id } => {
                if let Some(image) = images.get(*id)
                    && lacks_mips(image)
                {
                    let image = image.clone();
                    let frames_left = FRAMES_KEPT;
                    mips.candidates
                        .insert(*id, Candidate { image, frames_left });
                }
            }
            AssetEvent::Removed { id } | AssetEvent::Unused { id } => {
                mips.candidates.remove(id);
                mips.tasks.remove(id);
                mips.used_textures.remove(id);
            }
            AssetEvent::LoadedWithDependencies { .. } => {}
        }
    }
}

fn start_tasks(mut mips: ResMut<MipGeneration>) {
    let mips = &mut *mips;
    let found: Vec<_> = mips
        .candidates
        .keys()
        .filter(|id| mips.used_textures.contains_key(*id))
        .copied()
        .collect();
    for id in found {
        let Some(Candidate { mut image, .. }) = mips.candidates.remove(&id) else {
            continue;
        };
        let size = image.texture_descriptor.size;
        let format = texel_format(image.texture_descriptor.format);
        let (Some(format), Some(data)) = (format, image.data.take()) else {
            continue;
        };
        let normals = mips.used_textures.get(&id).copied().unwrap_or_default();
        let task = AsyncComputeTaskPool::get().spawn(async move {
            generate_mip_chain([size.width, size.height], format, data, normals)
        });
        mips.tasks.insert(id, (image, task));
    }
}

fn finish_tasks(
    mut mips: ResMut<MipGeneration>,
    mut images: ResMut<Assets<Image>>,
    mut standard: ResMut<Assets<StandardMaterial>>,
    mut extended: ResMut<Assets<EwaStandardMaterial>>,
) {
    let mut finished = Vec::new();
    mips.tasks.retain(|id, (image, task)| {
        let Some(result) = block_on(future::poll_once(task)) else {
            return true;
        };
        if let Some(chain) = result
            && let Some(mut current) = images.get_mut(*id)
            // An image that was replaced in the meantime has a task of its own.
            && current.texture_descriptor == image.texture_descriptor
        {
            current.data = Some(chain.data);
            current.texture_descriptor.mip_level_count = chain.levels;
            finished.push(*id);
        }
        false
    });
    if finished.is_empty() {
        return;
    }
    // A material keeps the textures with which it was prepared.
    let uses = |material: &StandardMaterial| {
        maps(material).any(|map| finished.contains(&map.texture.id()))
    };
    let users = standard.iter().filter(|(_, material)| uses(material));
    for id in users.map(|(id, _)| id).collect::<Vec<_>>() {
        mark_modified(&mut standard, id);
    }
    let users = extended.iter().filter(|(_, material)| uses(&material.base));
    for id in users.map(|(id, _)| id).collect::<Vec<_>>() {
        mark_modified(&mut extended, id);
    }
}

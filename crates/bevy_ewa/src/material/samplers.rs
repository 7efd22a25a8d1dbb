//! Anisotropy of the samplers of textures, in the renderer: the images stay unchanged, and so do their texels, which
//! the renderer may have taken already.

use std::collections::{HashMap, hash_map::Entry};

use bevy::{
    image::ImageSamplerDescriptor,
    pbr::{MeshMaterial3d, StandardMaterial},
    prelude::*,
    render::{
        Extract, ExtractSchedule, Render, RenderApp, RenderSystems,
        erased_render_asset::prepare_erased_assets,
        render_asset::{RenderAssets, prepare_assets},
        render_resource::{Sampler, SamplerId},
        renderer::RenderDevice,
        texture::GpuImage,
    },
};

use super::{extension::EwaStandardMaterial, filtered::FilteredMaterials};

/// Replaces the samplers of textures before materials are prepared with them.
pub(super) struct SamplersPlugin;

impl Plugin for SamplersPlugin {
    fn build(&self, app: &mut App) {
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        render_app
            .init_resource::<AnisotropicSamplers>()
            .add_systems(ExtractSchedule, extract_samplers)
            .add_systems(
                Render,
                replace_samplers
                    .in_set(RenderSystems::PrepareAssets)
                    .after(prepare_assets::<GpuImage>)
                    .before(prepare_erased_assets::<MeshMaterial3d<StandardMaterial>>)
                    .before(prepare_erased_assets::<MeshMaterial3d<EwaStandardMaterial>>),
            );
    }
}

/// The samplers that textures shall have instead of their own.
#[derive(Resource, Default)]
struct AnisotropicSamplers(HashMap<AssetId<Image>, ImageSamplerDescriptor>);

fn extract_samplers(
    filtered: Extract<Res<FilteredMaterials>>,
    mut samplers: ResMut<AnisotropicSamplers>,
) {
    if !filtered.is_changed() {
        return;
    }
    let mut found: HashMap<_, ImageSamplerDescriptor> = HashMap::new();
    for material in filtered.materials.values() {
        for id in &material.textures {
            let image = filtered.images.get(*id);
            let sampler = image.and_then(|image| image.with_anisotropy(material.anisotropy));
            let Some(sampler) = sampler else {
                continue;
            };
            match found.entry(*id) {
                Entry::Occupied(entry)
                    if entry.get().anisotropy_clamp >= sampler.anisotropy_clamp => {}
                Entry::Occupied(mut entry) => {
                    entry.insert(sampler);
                }
                Entry::Vacant(entry) => {
                    entry.insert(sampler);
                }
            }
        }
    }
    if found != samplers.0 {
        samplers.0 = found;
    }
}

/// A sampler in the place of another one.
struct Replaced {
    original: Sampler,
    id: SamplerId,
    descriptor: ImageSamplerDescriptor,
}

fn replace_samplers(
    wanted: Res<AnisotropicSamplers>,
    device: Res<RenderDevice>,
    mut images: ResMut<RenderAssets<GpuImage>>,
    mut all_replaced: Local<HashMap<AssetId<Image>, Replaced>>,
) {
    if !wanted.is_changed() && !images.is_changed() {
        return;
    }
    // Its own changes are none that have to be followed.
    let images = images.bypass_change_detection();
    all_replaced.retain(|id, replaced| {
        let Some(image) = images.get_mut(*id) else {
            return false;
        };
        // An image that was prepared again has its own sampler again.
        let is_replaced = image.sampler.id() == replaced.id;
        let is_wanted = wanted.0.get(id) == Some(&replaced.descriptor);
        if is_replaced && !is_wanted {
            image.sampler = replaced.original.clone();
        }
        is_replaced && is_wanted
    });
    for (id, descriptor) in &wanted.0 {
        if all_replaced.contains_key(id) {
            continue;
        }
        if let Some(image) = images.get_mut(*id) {
            let sampler = device.create_sampler(&descriptor.as_wgpu());
            let replaced = Replaced {
                id: sampler.id(),
                original: std::mem::replace(&mut image.sampler, sampler),
                descriptor: descriptor.clone(),
            };
            all_replaced.insert(*id, replaced);
        }
    }
}

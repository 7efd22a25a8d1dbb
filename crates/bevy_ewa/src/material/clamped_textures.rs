//! Finds the materials with a clamped texture.
//!
//! Large texture coordinates are reduced by whole periods, to stay precise, where every texture of a
//! material repeats or mirrors. All maps of a material share the shader defs of its pipeline, so that a
//! single sampler that clamps switches this off for all of them.

use std::collections::HashSet;

use bevy::{
    asset::{AssetEventSystems, UntypedAssetId},
    image::{ImageAddressMode, ImageSampler, ImageSamplerDescriptor},
    prelude::*,
    render::{Extract, ExtractSchedule, RenderApp, render_resource::RenderPipelineDescriptor},
};
use bevy_frugal_hooks::{MaterialTags, SpecializedMaterial};

use super::{extension::EwaStandardMaterial, maps::maps, mark_modified::mark_modified, pipeline};

const TAG: &str = "bevy_ewa/clamped";

/// Finds the materials with a clamped texture and tags them.
pub(super) struct ClampedTexturesPlugin;

impl Plugin for ClampedTexturesPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Clamped>()
            .add_systems(PostUpdate, find_clamped.after(AssetEventSystems));
        if let Some(render_app) = app.get_sub_app_mut(RenderApp) {
            render_app.add_systems(ExtractSchedule, tag_materials);
        }
    }

    fn finish(&self, app: &mut App) {
        let plugins = app.get_added_plugins::<ImagePlugin>();
        if let Some(plugin) = plugins.first() {
            let sampler = plugin.default_sampler.clone();
            app.world_mut().resource_mut::<Clamped>().default_sampler = sampler;
        }
    }
}

/// The images whose sampler clamps, and the materials that use one of them.
#[derive(Resource, Default)]
struct Clamped {
    default_sampler: ImageSamplerDescriptor,
    images: HashSet<AssetId<Image>>,
    materials: HashSet<UntypedAssetId>,
}

impl Clamped {
    fn is_clamped(&self, image: &Image) -> bool {
        let sampler = match &image.sampler {
            ImageSampler::Default => &self.default_sampler,
            ImageSampler::Descriptor(sampler) => sampler,
        };
        let modes = [sampler.address_mode_u, sampler.address_mode_v];
        modes.iter().any(|mode| {
            matches!(
                mode,
                ImageAddressMode::ClampToEdge | ImageAddressMode::ClampToBorder
            )
        })
    }
}

fn find_clamped(
    mut clamped: ResMut<Clamped>,
    images: Res<Assets<Image>>,
    mut image_events: MessageReader<AssetEvent<Image>>,
    mut standard: ResMut<Assets<StandardMaterial>>,
    mut standard_events: MessageReader<AssetEvent<StandardMaterial>>,
    mut extended: ResMut<Assets<EwaStandardMaterial>>,
    mut extended_events: MessageReader<AssetEvent<EwaStandardMaterial>>,
) {
    let clamped = &mut *clamped;
    let mut images_changed = false;
    for event in image_events.read() {
        images_changed |= match event {
            AssetEvent::Added { id } | AssetEvent::Modified { id } => {
                let image = images.get(*id);
                let found = image.is_some_and(|image| clamped.is_clamped(image));
                set(&mut clamped.images, *id, found)
            }
            AssetEvent::Removed { id } => set(&mut clamped.images, *id, false),
            AssetEvent::Unused { .. } | AssetEvent::LoadedWithDependencies { .. } => false,
        };
    }
    update_materials(
        clamped,
        images_changed,
        &mut standard,
        standard_events.read(),
        |m| m,
    );
    update_materials(
        clamped,
        images_changed,
        &mut extended,
        extended_events.read(),
        |m| &m.base,
    );
}

/// Checks the materials that changed, or all materials after an image changed.
fn update_materials<'a, M: Asset>(
    clamped: &mut Clamped,
    images_changed: bool,
    materials: &mut Assets<M>,
    events: impl Iterator<Item = &'a AssetEvent<M>>,
    base: impl Fn(&M) -> &StandardMaterial,
) {
    let is_clamped = |clamped: &Clamped, material: &M| {
        maps(base(material)).any(|(map, _)| clamped.images.contains(&map.id()))
    };
    for event in events {
        match event {
            AssetEvent::Added { id } | AssetEvent::Modified { id } => {
                if let Some(material) = materials.get(*id) {
                    let found = is_clamped(clamped, material);
                    set(&mut clamped.materials, (*id).into(), found);
                }
            }
            AssetEvent::Removed { id } | AssetEvent::Unused { id } => {
                set(&mut clamped.materials, (*id).into(), false);
            }
            AssetEvent::LoadedWithDependencies { .. } => {}
        }
    }
    if images_changed {
        let mut changed = Vec::new();
        for (id, material) in materials.iter() {
            let found = is_clamped(clamped, material);
            if set(&mut clamped.materials, id.into(), found) {
                changed.push(id);
            }
        }
        // These were prepared with the former tag.
        for id in changed {
            mark_modified(materials, id);
        }
    }
}

/// Adds or removes an id, and returns whether the set changed.
fn set<I: Eq + std::hash::Hash>(ids: &mut HashSet<I>, id: I, clamped: bool) -> bool {
    if clamped {
        ids.insert(id)
    } else {
        ids.remove(&id)
    }
}

fn tag_materials(
    clamped: Extract<Res<Clamped>>,
    mut tagged: Local<HashSet<UntypedAssetId>>,
    mut tags: ResMut<MaterialTags>,
) {
    for id in tagged.difference(&clamped.materials) {
        tags.set_for_material(*id, TAG, None);
    }
    for id in clamped.materials.difference(&tagged) {
        tags.set_for_material(*id, TAG, Some(1));
    }
    if *tagged != clamped.materials {
        tagged.clone_from(&clamped.materials);
    }
}

/// Part of the material hook; runs after the shader defs of the filter are set.
pub(super) fn disable_periodic(
    material: SpecializedMaterial,
    descriptor: &mut RenderPipelineDescriptor,
) {
    if material.tag(TAG).is_some()
        && let Some(fragment) = &mut descriptor.fragment
    {
        pipeline::disable_periodic(&mut fragment.shader_defs);
    }
}

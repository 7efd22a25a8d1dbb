//! Finds the materials that are filtered, and tags them so that their pipelines are specialized.
//!
//! The settings and the layout of a material's maps are in its pipeline's key, as a tag. A pipeline is compiled for the
//! maps that its material has: Bevy asks whether there is a map at run time, which costs the filter's code for all maps.

use std::{
    collections::HashMap,
    sync::{PoisonError, RwLock},
};

use bevy::{
    asset::{AssetEventSystems, UntypedAssetId},
    prelude::*,
    render::{
        Extract, ExtractSchedule, RenderApp, render_resource::RenderPipelineDescriptor,
        renderer::RenderAdapterInfo,
    },
};
use bevy_frugal_hooks::{MaterialHookPlugin, MaterialTags, ShaderPatches, SpecializedMaterial};

use super::{
    all_materials::AllMaterials,
    extension::EwaStandardMaterial,
    images::Images,
    layout::MapLayout,
    llvmpipe::{self, is_llvmpipe},
    maps::maps,
    mark_modified::mark_modified,
    patches::Refused,
    pipeline::EwaKey,
};
use crate::settings::EwaSettings;

/// Tags the materials and specializes their pipelines.
pub(super) struct FilteredMaterialsPlugin;

impl Plugin for FilteredMaterialsPlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<AllMaterials>()
            .init_resource::<AllMaterials>()
            .init_resource::<FilteredMaterials>()
            .add_plugins(MaterialHookPlugin(apply_filter))
            .add_systems(PostUpdate, find_filtered.after(AssetEventSystems));
        if let Some(render_app) = app.get_sub_app_mut(RenderApp) {
            render_app.add_systems(ExtractSchedule, tag_materials);
        }
    }

    fn finish(&self, app: &mut App) {
        if let Some(info) = app.world().get_resource::<RenderAdapterInfo>() {
            llvmpipe::detect(info);
        }
        let plugins = app.get_added_plugins::<ImagePlugin>();
        if let Some(plugin) = plugins.first() {
            let sampler = plugin.default_sampler.clone();
            let mut filtered = app.world_mut().resource_mut::<FilteredMaterials>();
            filtered.images.default_sampler = sampler;
        }
    }
}

/// What pipelines are compiled with; a tag is an index. It grows with the distinct settings and layouts, not with the
/// materials. Hooks have no access to a world.
static KEYS: RwLock<Vec<(EwaKey, MapLayout)>> = RwLock::new(Vec::new());

const TAG: &str = "bevy_ewa";

fn index_of(key: (EwaKey, MapLayout)) -> u64 {
    let mut keys = KEYS.write().unwrap_or_else(PoisonError::into_inner);
    let index = keys.iter().position(|known| *known == key);
    index.unwrap_or_else(|| {
        keys.push(key);
        keys.len() - 1
    }) as u64
}

/// The materials that are not left to Bevy. Change detection reports it when one of them, or an image of theirs, was
/// replaced.
#[derive(Resource, Default)]
pub(super) struct FilteredMaterials {
    pub(super) images: Images,
    pub(super) materials: HashMap<UntypedAssetId, Filtered>,
}

/// How a material is filtered.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Filtered {
    /// Index in `KEYS`, unless its pipelines are Bevy's own.
    tag: Option<u64>,
    /// The `anisotropy_clamp` of the textures' samplers.
    pub(super) anisotropy: u16,
    /// The textures whose samplers get `anisotropy`; none where it is 1.
    pub(super) textures: Vec<AssetId<Image>>,
}

impl Filtered {
    fn new(
        settings: EwaSettings,
        refused: Refused,
        material: &StandardMaterial,
        images: &Images,
    ) -> Self {
        let chosen = refused.filterable(settings.maps, material);
        let layout = MapLayout::of(material, chosen, images);
        let key = EwaKey::new(&settings, is_llvmpipe()).filter(|_| !layout.is_empty());
        let anisotropy = settings.texture_unit_anisotropy();
        // Exact methods read single texels, for which anisotropy is of no use.
        let is_used =
            |name| anisotropy > 1 && !(settings.method.is_exact() && chosen.contains(name));
        let textures = maps(material).filter(|map| is_used(map.name()));
        Self {
            tag: key.map(|key| index_of((key, layout))),
            anisotropy,
            textures: textures.map(|map| map.texture.id()).collect(),
        }
    }

    fn is_bevys_own(&self) -> bool {
        self.tag.is_none() && self.textures.is_empty()
    }
}

fn find_filtered(
    mut filtered: ResMut<FilteredMaterials>,
    all: Res<AllMaterials>,
    patches: Option<Res<ShaderPatches>>,
    mut last: Local<Option<(AllMaterials, Refused)>>,
    images: Res<Assets<Image>>,
    mut image_events: MessageReader<AssetEvent<Image>>,
    mut standard: ResMut<Assets<StandardMaterial>>,
    mut standard_events: MessageReader<AssetEvent<StandardMaterial>>,
    mut extended: ResMut<Assets<EwaStandardMaterial>>,
    mut extended_events: MessageReader<AssetEvent<EwaStandardMaterial>>,
) {
    let refused = patches.map_or_else(default, |patches| Refused::new(&patches));
    let current = Some((*all, refused));
    let mut are_all_stale = std::mem::replace(&mut *last, current) != current;
    let state = filtered.bypass_change_detection();
    for event in image_events.read() {
        are_all_stale |= state.images.follow(event, &images);
    }
    let of_standard = |material: &StandardMaterial, images: &Images| {
        Some(Filtered::new(all.0?, refused, material, images))
    };
    let of_extended = |material: &EwaStandardMaterial, images: &Images| {
        let settings = material.extension.settings;
        Some(Filtered::new(settings, refused, &material.base, images))
    };
    let mut has_changed = are_all_stale;
    has_changed |= follow(
        state,
        are_all_stale,
        &mut standard,
        standard_events.read(),
        of_standard,
    );
    has_changed |= follow(
        state,
        are_all_stale,
        &mut extended,
        extended_events.read(),
        of_extended,
    );
    if has_changed {
        filtered.set_changed();
    }
}

/// Checks the materials that changed, or all materials, and returns whether one is filtered otherwise now.
fn follow<'a, M: Asset>(
    state: &mut FilteredMaterials,
    are_all_stale: bool,
    materials: &mut Assets<M>,
    events: impl Iterator<Item = &'a AssetEvent<M>>,
    filtered: impl Fn(&M, &Images) -> Option<Filtered>,
) -> bool {
    let mut has_changed = false;
    for event in events {
        has_changed |= match event {
            AssetEvent::Added { id } | AssetEvent::Modified { id } => {
                let material = materials.get(*id);
                let found = material.and_then(|material| filtered(material, &state.images));
                state.set((*id).into(), found)
            }
            AssetEvent::Removed { id } => state.set((*id).into(), None),
            AssetEvent::Unused { .. } | AssetEvent::LoadedWithDependencies { .. } => false,
        };
    }
    if are_all_stale {
        let mut changed = Vec::new();
        for (id, material) in materials.iter() {
            let found = filtered(material, &state.images);
            if state.set(id.into(), found) {
                changed.push(id);
            }
        }
        has_changed |= !changed.is_empty();
        // The key of a pipeline is made when its material is prepared.
        for id in changed {
            mark_modified(materials, id);
        }
    }
    has_changed
}

impl FilteredMaterials {
    /// Sets how a material is filtered, and returns whether that is another way than before.
    fn set(&mut self, id: UntypedAssetId, filtered: Option<Filtered>) -> bool {
        match filtered.filter(|filtered| !filtered.is_bevys_own()) {
            Some(filtered) => {
                let former = self.materials.insert(id, filtered);
                former.as_ref() != self.materials.get(&id)
            }
            None => self.materials.remove(&id).is_some(),
        }
    }
}

fn tag_materials(
    filtered: Extract<Res<FilteredMaterials>>,
    mut tagged: Local<HashMap<UntypedAssetId, u64>>,
    mut tags: ResMut<MaterialTags>,
) {
    if !filtered.is_changed() {
        return;
    }
    let found =
        { filtered.materials.iter() }.filter_map(|(id, filtered)| Some((*id, filtered.tag?)));
    let found: HashMap<_, _> = found.collect();
    for id in tagged.keys().filter(|id| !found.contains_key(*id)) {
        tags.set_for_material(*id, TAG, None);
    }
    for (id, tag) in &found {
        if tagged.get(id) != Some(tag) {
            tags.set_for_material(*id, TAG, Some(*tag));
        }
    }
    *tagged = found;
}

/// The material hook.
fn apply_filter(material: SpecializedMaterial, descriptor: &mut RenderPipelineDescriptor) {
    let Some(index) = material.tag(TAG) else {
        return;
    };
    let keys = KEYS.read().unwrap_or_else(PoisonError::into_inner);
    if let Some((key, layout)) = keys.get(index as usize) {
        key.apply(*layout, material.mesh_key, descriptor);
    }
}

//! The settings and the layout of a material's maps, as tags in the key of its pipelines.
//!
//! A pipeline is compiled for the maps that its material has: Bevy asks whether there is a map at run time, which costs
//! the filter's code for all maps.

use std::sync::{PoisonError, RwLock};

use bevy::{
    prelude::*,
    render::{Extract, ExtractSchedule, RenderApp, render_resource::RenderPipelineDescriptor},
};
use bevy_frugal_hooks::{MaterialHookPlugin, MaterialTags, SpecializedMaterial};

use super::{filtered::FilteredMaterials, layout::MapLayout, pipeline::EwaKey};

/// Tags the materials and specializes their pipelines.
pub(super) struct TagsPlugin;

impl Plugin for TagsPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins(MaterialHookPlugin(apply_filter));
        if let Some(render_app) = app.get_sub_app_mut(RenderApp) {
            render_app.add_systems(ExtractSchedule, tag_materials);
        }
    }
}

/// What pipelines are compiled with; a tag is an index. It grows with the distinct settings and layouts, not with the
/// materials. Hooks have no access to a world.
static KEYS: RwLock<Vec<(EwaKey, MapLayout)>> = RwLock::new(Vec::new());

const TAG: &str = "bevy_ewa";

/// The tag of materials that are filtered so.
pub(super) fn tag_of(key: (EwaKey, MapLayout)) -> u64 {
    let mut keys = KEYS.write().unwrap_or_else(PoisonError::into_inner);
    let index = keys.iter().position(|known| *known == key);
    index.unwrap_or_else(|| {
        keys.push(key);
        keys.len() - 1
    }) as u64
}

fn tag_materials(filtered: Extract<Res<FilteredMaterials>>, mut tags: ResMut<MaterialTags>) {
    for (id, tag) in &filtered.changes.tags {
        tags.set_for_material(*id, TAG, *tag);
    }
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

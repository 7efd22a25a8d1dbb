//! The settings and the layout of a material's maps, as tags in the key of its pipelines.
//!
//! A pipeline is compiled for the maps that its material has: Bevy asks whether there is a map at run time, which costs
//! the filter's code for all maps.

use bevy::{
    prelude::*,
    render::{Extract, ExtractSchedule, RenderApp, render_resource::RenderPipelineDescriptor},
};
use bevy_frugal_hooks::{MaterialHookPlugin, MaterialTags, SpecializedMaterial};

use super::{filtered::FilteredMaterials, pipeline::key_of};

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

const TAG: &str = "bevy_ewa";

fn tag_materials(filtered: Extract<Res<FilteredMaterials>>, mut tags: ResMut<MaterialTags>) {
    for (id, tag) in &filtered.changes.tags {
        tags.set_for_material(*id, TAG, *tag);
    }
}

/// The material hook.
fn apply_filter(material: SpecializedMaterial, descriptor: &mut RenderPipelineDescriptor) {
    if let Some((key, layout)) = material.tag(TAG).and_then(key_of) {
        key.apply(layout, material.mesh_key, descriptor);
    }
}

//! Extension of Bevy's renderer by the plugins of this workspace, without a fork of it.
//!
//! Bevy has no API for a change of every material. This crate has two mechanisms for it, patches of
//! shaders and hooks, which several plugins can use at once and in any order, and mends what Bevy lacks for
//! views that change:
//!
//! | item | contents |
//! | --- | --- |
//! | [`shader_patch`] | verified insertions into Bevy's shaders at start-up, each at most once |
//! | [`material_hook`] | hooks at the end of the specialization of every material's pipeline, and tags of materials |
//! | [`ViewWireframesPlugin`] | wireframes that follow their views |
//! | [`MaterialImages`] | images of materials whose maps are other kinds of textures |
//! | [`format_features`] | what a device can do with a texture format |
//!
//! All depend on Bevy's internals and may fail with another version of Bevy. A plugin checks
//! [`ShaderPatches::state`] before it relies on a patch, and leaves the rendering to Bevy if the patch
//! was refused.

pub mod material_hook;
pub mod shader_patch;

use bevy::{
    asset::UntypedAssetId,
    mesh::UvChannel,
    pbr::check_views_need_specialization,
    platform::collections::HashMap,
    prelude::*,
    render::{
        Render, RenderApp, RenderSystems,
        camera::{DirtySpecializations, DirtyWireframeSpecializations},
        render_resource::{TextureFormat, TextureFormatFeatures, WgpuFeatures},
        renderer::{RenderAdapter, RenderDevice},
    },
};

pub use material_hook::{MaterialHook, MaterialHookPlugin, MaterialTags, SpecializedMaterial};
pub use shader_patch::{Insertion, PatchState, ShaderPatch, ShaderPatches};

/// Specializes wireframes anew where the materials of a view are. Plugins that change views while the app runs
/// add it, unless it has been added.
///
/// Bevy 0.20 specializes the pipelines of wireframes anew when a mesh or its wireframe changes, but not when a
/// view does, as it does for materials: where a view gets an irradiance volume or another format later than its
/// wireframes, they are drawn by pipelines that do not fit its bind group, which ends the app.
#[derive(Clone, Copy, Debug, Default)]
pub struct ViewWireframesPlugin;

impl Plugin for ViewWireframesPlugin {
    fn build(&self, app: &mut App) {
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        render_app.add_systems(
            Render,
            mark_wireframes_of_changed_views
                .after(check_views_need_specialization)
                .in_set(RenderSystems::PrepareAssets),
        );
    }
}

fn mark_wireframes_of_changed_views(
    materials: Res<DirtySpecializations>,
    mut wireframes: ResMut<DirtyWireframeSpecializations>,
) {
    wireframes.views.extend(&materials.views);
}

/// A small image that looks as a map does from afar.
#[derive(Clone, Debug, PartialEq)]
pub struct MapImage {
    /// The image, whose coordinates repeat.
    pub image: AssetId<Image>,
    /// The texture coordinates of the map.
    pub channel: UvChannel,
}

/// The images of a material's maps. `None` where it has no such map, or has it as an image of its own.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MapImages {
    /// Multiplied with the base colour.
    pub base_color: Option<MapImage>,
    /// Multiplied with the emissive colour.
    pub emissive: Option<MapImage>,
    /// Its blue channel is multiplied with the metallic value.
    pub metallic_roughness: Option<MapImage>,
}

/// The images of materials whose maps are other kinds of textures, by their assets, for plugins that read maps outside
/// of the materials' own shaders.
///
/// Plugins that read them insert this resource when they are built. Plugins with such materials fill it where it is, after
/// `AssetEventSystems` in `PostUpdate`, so that nothing is made that nobody reads.
#[derive(Resource, Clone, Debug, Default)]
pub struct MaterialImages(pub HashMap<UntypedAssetId, MapImages>);

/// Returns what the device can do with a format: all that the adapter can, or what WebGPU guarantees.
pub fn format_features(
    format: TextureFormat,
    adapter: &RenderAdapter,
    device: &RenderDevice,
) -> TextureFormatFeatures {
    let features = device.features();
    if features.contains(WgpuFeatures::TEXTURE_ADAPTER_SPECIFIC_FORMAT_FEATURES) {
        adapter.get_texture_format_features(format)
    } else {
        format.guaranteed_format_features(features)
    }
}

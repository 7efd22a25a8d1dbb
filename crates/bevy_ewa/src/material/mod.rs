//! Integration of the filter into Bevy's materials.
//!
//! | module | contents |
//! | --- | --- |
//! | [`patches`] | statements in Bevy's shaders that are compiled only with the shader defs of the filter |
//! | [`pipeline`] | the settings and the layout as shader defs of a pipeline |
//! | [`layout`] | the maps of a material that are filtered together |
//! | [`extension`] | filtering of single materials |
//! | [`all_materials`] | filtering of all `StandardMaterial`s |
//! | [`overrides`] | what the app decides for single images and materials |
//! | `filtered` | the materials that are filtered |
//! | [`material_plugin`] | the plugin of a type of material |
//! | `textures`, `wanted` | what the textures of filtered materials need |
//! | `tags` | the filtered materials, as tags in the keys of their pipelines |
//! | [`prepared`] | mip levels and samplers of textures in the renderer |
//! | `maps` | the textures of a material |
//! | `images` | sizes, samplers and possible mip levels of images |
//! | `adapter` | detection of drivers that need workarounds |
//!
//! The shaders `sample_map.wesl` and `shared_maps.wesl` are what the statements in Bevy's shaders call.

mod adapter;
pub mod all_materials;
pub mod extension;
mod filtered;
mod images;
pub mod layout;
pub(crate) mod maps;
pub mod material_plugin;
pub mod overrides;
pub mod patches;
pub mod pipeline;
pub mod prepared;
mod tags;
mod textures;
mod wanted;

use bevy::{
    pbr::MaterialPlugin, prelude::*, render::renderer::RenderAdapterInfo,
    shader::load_shader_library,
};
use bevy_frugal_hooks::shader_patch::PatchShadersExt;

pub use all_materials::AllMaterials;
pub use extension::{EwaExtension, EwaStandardMaterial};
pub use material_plugin::EwaMaterialPlugin;
pub use overrides::{EwaImage, EwaOverrides};
pub use prepared::EwaMipSystems;

/// Patches Bevy's shaders and registers both kinds of filtered materials.
pub(crate) struct MaterialsPlugin;

impl Plugin for MaterialsPlugin {
    fn build(&self, app: &mut App) {
        load_shader_library!(app, "sample_map.wesl");
        load_shader_library!(app, "shared_maps.wesl");
        for patch in patches::patches() {
            app.patch_shader(patch);
        }
        app.add_plugins((
            MaterialPlugin::<EwaStandardMaterial>::default(),
            filtered::FilteredMaterialsPlugin,
            textures::TexturesPlugin,
            EwaMaterialPlugin::<StandardMaterial>::default(),
            EwaMaterialPlugin::<EwaStandardMaterial>::default(),
            tags::TagsPlugin,
            prepared::PreparedTexturesPlugin,
        ))
        .register_type::<EwaExtension>()
        .register_asset_reflect::<EwaStandardMaterial>();
    }

    fn finish(&self, app: &mut App) {
        if let Some(info) = app.world().get_resource::<RenderAdapterInfo>() {
            adapter::detect(info);
        }
    }
}

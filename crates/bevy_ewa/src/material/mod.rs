//! Integration of the filter into Bevy's materials.
//!
//! | module | contents |
//! | --- | --- |
//! | [`settings`] | the settings of all materials, of single materials and images |
//! | [`layout`] | the images, the maps of a material, and which of them are filtered together |
//! | `filtered` | the plugin of a type of material, which materials are filtered, and what their textures need |
//! | [`patches`] | statements in Bevy's shaders that are compiled only with the shader defs of the filter |
//! | [`pipeline`] | the settings and the layout as shader defs of a pipeline, on drivers that need workarounds, too |
//! | [`prepared`] | mip levels and samplers of textures in the renderer |
//!
//! The shaders `sample_map.wesl` and `shared_maps.wesl` are what the statements in Bevy's shaders call.

mod filtered;
pub mod layout;
pub mod patches;
pub mod pipeline;
pub mod prepared;
pub mod settings;

use bevy::{
    pbr::MaterialPlugin, prelude::*, render::renderer::RenderAdapterInfo,
    shader::load_shader_library,
};
use bevy_frugal_hooks::{MaterialHookPlugin, shader_patch::PatchShadersExt};

pub use filtered::EwaMaterialPlugin;
pub use prepared::EwaMipSystems;
pub use settings::{AllMaterials, EwaExtension, EwaImage, EwaOverrides, EwaStandardMaterial};

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
            EwaMaterialPlugin::<StandardMaterial>::default(),
            EwaMaterialPlugin::<EwaStandardMaterial>::default(),
            MaterialHookPlugin(pipeline::apply_filter),
            prepared::PreparedTexturesPlugin,
        ))
        .register_type::<EwaExtension>()
        .register_asset_reflect::<EwaStandardMaterial>();
    }

    fn finish(&self, app: &mut App) {
        if let Some(info) = app.world().get_resource::<RenderAdapterInfo>() {
            pipeline::detect_adapter(info);
        }
    }
}

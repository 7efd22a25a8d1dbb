//! Integration of the filter into Bevy's materials.
//!
//! | module | contents |
//! | --- | --- |
//! | [`patches`] | statements in Bevy's shaders that are compiled only with the shader defs of the filter |
//! | [`pipeline`] | the settings and the layout as shader defs of a pipeline |
//! | [`layout`] | the maps of a material that are filtered together |
//! | [`extension`] | filtering of single materials |
//! | [`all_materials`] | filtering of all `StandardMaterial`s |
//! | `filtered` | the materials that are filtered, as tags in the keys of their pipelines |
//! | `samplers` | anisotropy of the samplers of textures |
//! | `maps` | the texture maps of a material |
//! | `images` | sizes and samplers of images |
//! | `llvmpipe` | detection of a driver that needs workarounds |
//! | `mark_modified` | preparation of an unchanged asset once more |
//!
//! The shaders `sample_map.wesl` and `shared_maps.wesl` are what the statements in Bevy's shaders call.

pub mod all_materials;
pub mod extension;
mod filtered;
mod images;
pub mod layout;
mod llvmpipe;
pub(crate) mod maps;
pub(crate) mod mark_modified;
pub mod patches;
pub mod pipeline;
mod samplers;

use bevy::{pbr::MaterialPlugin, prelude::*, shader::load_shader_library};
use bevy_frugal_hooks::shader_patch::PatchShadersExt;

pub use all_materials::AllMaterials;
pub use extension::{EwaExtension, EwaStandardMaterial};

/// Patches Bevy's shaders and registers both kinds of filtered materials.
pub(crate) struct EwaMaterialPlugin;

impl Plugin for EwaMaterialPlugin {
    fn build(&self, app: &mut App) {
        load_shader_library!(app, "sample_map.wesl");
        load_shader_library!(app, "shared_maps.wesl");
        for patch in patches::patches() {
            app.patch_shader(patch);
        }
        app.add_plugins((
            MaterialPlugin::<EwaStandardMaterial>::default(),
            filtered::FilteredMaterialsPlugin,
            samplers::SamplersPlugin,
        ))
        .register_type::<EwaExtension>();
    }
}

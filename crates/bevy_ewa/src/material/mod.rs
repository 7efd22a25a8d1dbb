//! Integration of the filter into Bevy's materials.
//!
//! | module | contents |
//! | --- | --- |
//! | [`pipeline`] | the settings as shader defs of a pipeline |
//! | [`patches`] | calls in Bevy's shaders that are compiled only with those defs |
//! | [`extension`] | filtering of single materials |
//! | [`all_materials`] | filtering of all `StandardMaterial`s |
//! | `maps` | the texture maps of a material |
//! | `clamped_textures` | detection of materials with clamped textures |
//! | `llvmpipe` | detection of a driver that needs workarounds |
//! | `mark_modified` | preparation of an unchanged asset once more |
//!
//! The shader `sample_map.wesl` is what the calls in Bevy's shaders call.

pub mod all_materials;
mod clamped_textures;
pub mod extension;
mod llvmpipe;
pub(crate) mod maps;
pub(crate) mod mark_modified;
pub mod patches;
pub mod pipeline;

use bevy::{pbr::MaterialPlugin, prelude::*, shader::load_shader_library};
use bevy_frugal_hooks::shader_patch::PatchShadersExt;

pub use all_materials::AllMaterials;
pub use extension::{EwaExtension, EwaStandardMaterial};

/// Patches Bevy's shaders and registers both kinds of filtered materials.
pub(crate) struct EwaMaterialPlugin;

impl Plugin for EwaMaterialPlugin {
    fn build(&self, app: &mut App) {
        load_shader_library!(app, "sample_map.wesl");
        for patch in patches::patches() {
            app.patch_shader(patch);
        }
        app.add_plugins((
            MaterialPlugin::<EwaStandardMaterial>::default(),
            all_materials::AllMaterialsPlugin,
            clamped_textures::ClampedTexturesPlugin,
        ))
        .register_type::<EwaExtension>();
    }
}

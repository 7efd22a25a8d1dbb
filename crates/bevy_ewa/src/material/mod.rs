//! Integration of the filter into Bevy's materials.
//!
//! | module | contents |
//! | --- | --- |
//! | [`uniform`] | the settings as a uniform buffer |
//! | [`pipeline`] | the settings as shader defs of a pipeline |
//! | [`patches`] | calls in Bevy's shaders that are compiled only with those defs |
//! | [`extension`] | filtering of single materials |
//! | [`all`] | filtering of all `StandardMaterial`s |
//! | `maps` | the texture maps of a material |
//! | `borders` | detection of materials with clamped textures |

pub mod all;
mod borders;
pub mod extension;
mod maps;
pub mod patches;
pub mod pipeline;
pub mod uniform;

use bevy::{pbr::MaterialPlugin, prelude::*};
use bevy_frugal_hooks::shader_patch::PatchShadersExt;

pub use all::AllMaterials;
pub use extension::{EwaExtension, EwaStandardMaterial};
pub(crate) use maps::maps;
pub use uniform::EwaUniform;

/// Patches Bevy's shaders and registers both kinds of filtered materials.
pub(crate) struct EwaMaterialPlugin;

impl Plugin for EwaMaterialPlugin {
    fn build(&self, app: &mut App) {
        for patch in patches::patches() {
            app.patch_shader(patch);
        }
        app.add_plugins((
            MaterialPlugin::<EwaStandardMaterial>::default(),
            all::AllMaterialsPlugin,
            borders::BordersPlugin,
        ))
        .register_type::<EwaExtension>();
    }
}

/// Marks an asset as modified, so that the renderer prepares it again.
pub(crate) fn touch<A: Asset>(assets: &mut Assets<A>, id: AssetId<A>) {
    if let Some(mut asset) = assets.get_mut(id) {
        // Only a mutable reference marks the asset as modified.
        let _: &mut A = &mut asset;
    }
}

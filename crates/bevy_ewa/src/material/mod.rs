//! How materials come to filter their maps.
//!
//! | module | gives |
//! | --- | --- |
//! | [`uniform`] | the settings as a shader sees them |
//! | [`pipeline`] | the settings as shader defs of a pipeline |
//! | [`patches`] | calls in Bevy's shaders that do nothing without those defs |
//! | [`extension`] | for chosen materials |
//! | [`all`] | for all of them |
//! | `maps` | the maps of a material |
//! | `borders` | which of them have textures that do not repeat |

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

/// Makes materials filter.
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

/// Has an asset prepared again.
pub(crate) fn touch<A: Asset>(assets: &mut Assets<A>, id: AssetId<A>) {
    if let Some(mut asset) = assets.get_mut(id) {
        // Only a mutable reference counts as a change.
        let _: &mut A = &mut asset;
    }
}

//! How materials come to filter their maps.
//!
//! | module | gives |
//! | --- | --- |
//! | [`uniform`] | the settings as a shader sees them |
//! | [`pipeline`] | the settings as shader defs of a pipeline |
//! | [`patches`] | calls in Bevy's shaders that do nothing without those defs |
//! | [`extension`] | for chosen materials |
//! | [`all`] | for all of them |

pub mod all;
pub mod extension;
pub mod patches;
pub mod pipeline;
pub mod uniform;

use bevy::{pbr::MaterialPlugin, prelude::*};
use bevy_frugal_hooks::shader_patch::PatchShadersExt;

pub use all::AllMaterials;
pub use extension::{EwaExtension, EwaStandardMaterial};
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
        ))
        .register_type::<EwaExtension>();
    }
}

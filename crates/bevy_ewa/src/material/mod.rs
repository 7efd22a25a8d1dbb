//! How materials come to filter their maps.
//!
//! | module | gives |
//! | --- | --- |
//! | [`uniform`] | the settings as a shader sees them |
//! | [`pipeline`] | the settings as shader defs of a pipeline |
//! | [`patches`] | calls in Bevy's shaders that do nothing without those defs |
//! | [`extension`] | for chosen materials |
//! | [`all`] | for all of them |
//! | `borders` | which of them have textures that do not repeat |

pub mod all;
mod borders;
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
            borders::BordersPlugin,
        ))
        .register_type::<EwaExtension>();
    }
}

/// The maps that are filtered, and whether they hold normals.
pub(crate) fn maps(material: &StandardMaterial) -> impl Iterator<Item = (&Handle<Image>, bool)> {
    let normals = [
        &material.normal_map_texture,
        &material.clearcoat_normal_texture,
    ];
    let others = [
        &material.base_color_texture,
        &material.emissive_texture,
        &material.metallic_roughness_texture,
        &material.occlusion_texture,
        &material.specular_texture,
        &material.specular_tint_texture,
        &material.clearcoat_texture,
        &material.clearcoat_roughness_texture,
        &material.specular_transmission_texture,
        &material.thickness_texture,
        &material.diffuse_transmission_texture,
        &material.anisotropy_texture,
    ];
    let normals = normals.into_iter().flatten().map(|map| (map, true));
    normals.chain(others.into_iter().flatten().map(|map| (map, false)))
}

/// Has an asset prepared again.
pub(crate) fn touch<A: Asset>(assets: &mut Assets<A>, id: AssetId<A>) {
    if let Some(mut asset) = assets.get_mut(id) {
        // Only a mutable reference counts as a change.
        let _: &mut A = &mut asset;
    }
}

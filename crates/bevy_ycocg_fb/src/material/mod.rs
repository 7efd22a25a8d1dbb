//! Packing in the shaders of materials, without a change of the materials.
//!
//! | module | contents |
//! | --- | --- |
//! | [`patches`] | calls in Bevy's shaders that pack under a shader def |
//! | [`pipeline`] | this shader def in the pipelines of packed cameras |
//! | [`detect`] | detection of the shaders that pack |
//! | [`final_call`] | whether the functions of a shader end in a call that packs |

pub mod detect;
mod final_call;
pub mod patches;
pub mod pipeline;

use bevy::{prelude::*, render::RenderApp};
use bevy_frugal_hooks::{MaterialHookPlugin, shader_patch::PatchShadersExt};

use crate::report::FrameBufferReport;
use detect::PackingShaders;

/// Patches Bevy's shaders and specializes the pipelines of materials for packed cameras.
pub(crate) struct MaterialPackingPlugin;

impl Plugin for MaterialPackingPlugin {
    fn build(&self, app: &mut App) {
        for patch in patches::patches() {
            app.patch_shader(patch);
        }
        let shaders = PackingShaders::default();
        app.insert_resource(shaders.clone())
            .add_systems(
                Last,
                detect::find_packing_shaders.run_if(any_with_component::<FrameBufferReport>),
            )
            .add_plugins(MaterialHookPlugin(pipeline::pack_for_packed_targets));
        if let Some(render_app) = app.get_sub_app_mut(RenderApp) {
            render_app.insert_resource(shaders);
        }
    }
}

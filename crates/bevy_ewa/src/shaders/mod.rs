//! The filters as WESL modules, which any shader can import.
//!
//! `ewa.wesl` has the functions to call, and `types.wesl` the settings that they take. The CPU reference
//! of each of the other modules is the module of the same name in [`reference`](mod@crate::reference).
//!
//! | module | contents |
//! | --- | --- |
//! | [`uniform`] | the settings as a uniform buffer, the struct `EwaSettings` of `types.wesl` |

pub mod uniform;

use bevy::{prelude::*, shader::load_shader_library};

pub use uniform::EwaUniform;

/// Makes the modules available to the shaders of an app.
pub(crate) struct EwaShadersPlugin;

impl Plugin for EwaShadersPlugin {
    fn build(&self, app: &mut App) {
        load_shader_library!(app, "types.wesl");
        load_shader_library!(app, "kernel.wesl");
        load_shader_library!(app, "footprint.wesl");
        load_shader_library!(app, "exact.wesl");
        load_shader_library!(app, "probes.wesl");
        load_shader_library!(app, "stochastic.wesl");
        load_shader_library!(app, "ewa.wesl");
    }
}

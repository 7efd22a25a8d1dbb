//! Insertion of text into Bevy's shaders when they are loaded.
//!
//! A [`ShaderPatch`] only inserts, at positions that must exist exactly once. It removes nothing, so
//! the anchors of other patches stay intact and the order of patches does not matter. It writes its name
//! into the source and is therefore never applied twice; it is applied again when the shader is
//! reloaded. If it does not fit, as may happen with another version of Bevy, the shader stays
//! unchanged, the patch is [`PatchState::Refused`] and one error names the shader and the reason.
//!
//! | module | contents |
//! | --- | --- |
//! | `patch` | the description of a patch |
//! | `insert` | insertion into a shader's source text |
//! | `apply` | application to the shaders of an app, and the state of each patch |

mod apply;
mod insert;
mod patch;

pub use apply::{PatchShadersExt, PatchState, ShaderPatches};
pub use insert::{PatchError, patched};
pub use patch::{Insertion, ShaderPatch};

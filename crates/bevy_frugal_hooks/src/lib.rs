//! How the plugins of this workspace reach into Bevy's renderer without a fork of it.
//!
//! Bevy offers no place for "every material, changed a little". These are the two that work, made
//! safe for several plugins at once, in any order:
//!
//! | module | gives |
//! | --- | --- |
//! | [`shader_patch`] | text inserted into Bevy's shaders at start-up, verified, never twice |
//! | [`specialize`] | a last word on the pipeline of every material |
//!
//! Both depend on Bevy's insides, so both say whether they took hold: a plugin asks
//! [`ShaderPatches::state`] before it relies on a patch and steps aside where it was refused.

pub mod shader_patch;
pub mod specialize;

pub use shader_patch::{Insertion, PatchState, ShaderPatch, ShaderPatches};
pub use specialize::{MaterialHook, MaterialHookPlugin, MaterialTags, SpecializedMaterial};

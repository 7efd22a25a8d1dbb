//! Extension of Bevy's renderer by the plugins of this workspace, without a fork of it.
//!
//! Bevy has no API for a change of every material. This crate has two mechanisms for it, patches of
//! shaders and hooks, which several plugins can use at once and in any order, and mends what Bevy lacks for
//! views that change:
//!
//! | module | contents |
//! | --- | --- |
//! | [`shader_patch`] | verified insertions into Bevy's shaders at start-up, each at most once |
//! | [`material_hook`] | hooks at the end of the specialization of every material's pipeline, and tags of materials |
//! | [`wireframes`] | wireframes that follow their views |
//! | [`material_images`] | images of materials whose maps are other kinds of textures |
//!
//! All depend on Bevy's internals and may fail with another version of Bevy. A plugin checks
//! [`ShaderPatches::state`] before it relies on a patch, and leaves the rendering to Bevy if the patch
//! was refused.

pub mod material_hook;
pub mod material_images;
pub mod shader_patch;
pub mod wireframes;

pub use material_hook::{MaterialHook, MaterialHookPlugin, MaterialTags, SpecializedMaterial};
pub use material_images::{MapImage, MapImages, MaterialImages};
pub use shader_patch::{Insertion, PatchState, ShaderPatch, ShaderPatches};
pub use wireframes::ViewWireframesPlugin;

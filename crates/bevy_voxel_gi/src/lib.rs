//! Dynamic diffuse global illumination from a voxelised scene.
//!
//! The scene is voxelised each frame, light sources illuminate the voxels, light bounces between the
//! surfaces in them, and every material that uses Bevy's lighting receives the result (P. Mavridis,
//! *Efficient Texture Representation and Sampling Algorithms for Real-time Rendering*, 2013, chapter 6).
//!
//! | module | what it contains |
//! | --- | --- |
//! | [`settings`] | all that a user sets |
//! | [`plugin`] | the plugins that an app adds |
//! | [`report`] | state and memory of the volume |
//! | [`mod@reference`] | voxelisation, ray tracing and light transport in plain Rust |
//! | [`budget`] | quality control by a time budget |
//! | `extract` | placement of the volumes; meshes, materials and lights, inside a view or not |
//! | `prepare` | the work of a frame, and the buffers for it |
//! | `passes` | the compute passes: voxelisation and light transport |
//! | `receive` | reading the volume in pixel shaders |
//! | [`debug`] | a debug view of the voxels |
//! | `gpu_types` | the types that Rust and the shaders share |
//!
//! Without the feature `bevy` only `reference` is compiled.
#![cfg_attr(feature = "bevy", doc = "\n---\n")]
#![cfg_attr(feature = "bevy", doc = include_str!("../README.md"))]

#[cfg(feature = "bevy")]
pub mod budget;
#[cfg(feature = "bevy")]
pub mod debug;
#[cfg(feature = "bevy")]
mod extract;
#[cfg(feature = "bevy")]
mod gpu_types;
#[cfg(feature = "bevy")]
mod passes;
#[cfg(feature = "bevy")]
pub mod plugin;
#[cfg(feature = "bevy")]
mod prepare;
#[cfg(feature = "bevy")]
mod receive;
pub mod reference;
#[cfg(feature = "bevy")]
pub mod report;
#[cfg(feature = "bevy")]
pub mod settings;

#[cfg(feature = "bevy")]
pub use debug::{DebugField, VoxelGiDebug};
#[cfg(feature = "bevy")]
pub use extract::voxel_material::{AsVoxelMaterial, VoxelAlpha, VoxelMaterial, VoxelTexture};
#[cfg(feature = "bevy")]
pub use plugin::{VoxelGiBudgetPlugin, VoxelGiPlugin, VoxelMaterialPlugin};
#[cfg(feature = "bevy")]
pub use report::{VoxelGiReport, VoxelGiState};
#[cfg(feature = "bevy")]
pub use settings::{
    Bounces, MeshVoxelMaterial, NotVoxelized, Receiver, Sky, Solver, VoxelAlbedo, VoxelGiBudget,
    VoxelGiLight, VoxelGiSettings, VoxelGiVolume, VoxelLight, Voxelizer,
};

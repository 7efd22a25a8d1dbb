//! Dynamic diffuse global illumination from a voxelised scene.
//!
//! The scene is voxelised each frame, lamps light the voxels, light goes from surface to surface
//! through them, and every material with Bevy's lighting receives it (P. Mavridis, *Efficient
//! Texture Representation and Sampling Algorithms for Real-time Rendering*, 2013, chapter 6).
//!
//! | room | what is in it |
//! | --- | --- |
//! | [`settings`] | what a user chooses |
//! | [`mod@reference`] | voxels, rays and light in plain Rust |
//! | [`scene`] | meshes, surfaces and lamps, seen by a camera or not |
//! | `volume` | where the volume is, what it stores, what a frame computes |
//! | `voxelize` | from meshes to voxels |
//! | `light` | from voxels to light |
//! | `reproject` | from what cameras see to voxels |
//! | `receive` | from light to pixels |
//! | [`budget`] | the most accurate light that fits into a time |
//! | [`debug`] | the voxels as a picture |
//! | [`report`] | what became of the volume, and its memory |
//! | [`plugin`] | what an app adds |
//!
//! Without the feature `bevy` only `reference` is compiled.
#![cfg_attr(feature = "bevy", doc = "\n---\n")]
#![cfg_attr(feature = "bevy", doc = include_str!("../README.md"))]

#[cfg(feature = "bevy")]
pub mod budget;
#[cfg(feature = "bevy")]
pub mod debug;
#[cfg(feature = "bevy")]
mod light;
#[cfg(feature = "bevy")]
pub mod plugin;
#[cfg(feature = "bevy")]
mod receive;
pub mod reference;
#[cfg(feature = "bevy")]
pub mod report;
#[cfg(feature = "bevy")]
mod reproject;
#[cfg(feature = "bevy")]
pub mod scene;
#[cfg(feature = "bevy")]
pub mod settings;
#[cfg(feature = "bevy")]
mod volume;
#[cfg(feature = "bevy")]
mod voxelize;

#[cfg(feature = "bevy")]
pub use budget::{VoxelGiBudget, VoxelGiBudgetPlugin};
#[cfg(feature = "bevy")]
pub use debug::{DebugField, VoxelGiDebug};
#[cfg(feature = "bevy")]
pub use plugin::{VoxelGiPlugin, VoxelMaterialPlugin};
#[cfg(feature = "bevy")]
pub use report::{VoxelGiReport, VoxelGiState};
#[cfg(feature = "bevy")]
pub use scene::{MeshSurface, VoxelMaterial, VoxelSurface};
#[cfg(feature = "bevy")]
pub use settings::{
    Bounces, NotVoxelized, Receiver, Sky, Solver, VoxelAlbedo, VoxelGiVolume, VoxelLight, Voxelizer,
};

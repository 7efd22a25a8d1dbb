//! Dynamic diffuse global illumination from a voxelised scene.
//!
//! The scene is voxelised each frame, light sources illuminate the voxels, light bounces between the
//! surfaces in them, and every material that uses Bevy's lighting receives the result (P. Mavridis,
//! *Efficient Texture Representation and Sampling Algorithms for Real-time Rendering*, 2013, chapter 6).
//!
//! | module | what it contains |
//! | --- | --- |
//! | [`settings`] | the user's settings |
//! | [`mod@reference`] | voxelisation, ray tracing and light transport in plain Rust |
//! | [`scene`] | meshes, surfaces and lights, inside a view or not |
//! | `volume` | placement of the volume, its buffers, and the work of a frame |
//! | `voxelize` | meshes to voxels |
//! | `light` | light transport between the voxels |
//! | `reproject` | albedo from cameras' G-buffers to voxels |
//! | `receive` | reading the volume in pixel shaders |
//! | [`budget`] | quality control by a time budget |
//! | [`debug`] | a debug view of the voxels |
//! | [`report`] | state and memory of the volume |
//! | [`plugin`] | the plugins that an app adds |
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
pub use scene::{AsVoxelMaterial, MeshVoxelMaterial, VoxelMaterial};
#[cfg(feature = "bevy")]
pub use settings::{
    Bounces, NotVoxelized, Receiver, Sky, Solver, VoxelAlbedo, VoxelGiVolume, VoxelLight, Voxelizer,
};

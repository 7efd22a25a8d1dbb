//! Dynamic diffuse global illumination from a voxelised scene.
//!
//! Without the feature `bevy` only [`mod@reference`] is compiled.
#![cfg_attr(feature = "bevy", doc = "\n---\n")]
// The first definition of a link counts: on docs.rs the README's lead to the repository.
#![cfg_attr(feature = "bevy", doc = concat!("[architecture]: ", env!("CARGO_PKG_REPOSITORY"), "/blob/main/ARCHITECTURE.md"))]
#![cfg_attr(feature = "bevy", doc = concat!("[choosing]: ", env!("CARGO_PKG_REPOSITORY"), "/blob/main/docs/choosing-gi.md"))]
#![cfg_attr(feature = "bevy", doc = concat!("[figures]: ", env!("CARGO_PKG_REPOSITORY"), "/blob/main/docs/voxel_gi.md"))]
#![cfg_attr(feature = "bevy", doc = concat!("[migration]: ", env!("CARGO_PKG_REPOSITORY"), "/blob/main/docs/migration.md"))]
#![cfg_attr(feature = "bevy", doc = concat!("[picture]: ", env!("CARGO_PKG_REPOSITORY"), "/raw/main/docs/images/voxel_gi.jpg"))]
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
    Bounces, Follow, FollowTemplate, MeshVoxelMaterial, NotVoxelized, Receiver, Sky, Solver,
    VoxelAlbedo, VoxelGiBudget, VoxelGiLight, VoxelGiSettings, VoxelGiVolume,
    VoxelGiVolumeTemplate, VoxelLight, Voxelizer,
};

/// What most apps use: `use bevy_voxel_gi::prelude::*`.
#[cfg(feature = "bevy")]
pub mod prelude {
    pub use crate::{
        AsVoxelMaterial, Follow, FollowTemplate, MeshVoxelMaterial, NotVoxelized, Receiver, Sky,
        Solver, VoxelGiBudget, VoxelGiBudgetPlugin, VoxelGiDebug, VoxelGiPlugin, VoxelGiReport,
        VoxelGiSettings, VoxelGiVolume, VoxelLight, VoxelMaterial, VoxelMaterialPlugin,
    };
}

//! All that a user sets. Each type with a range has `clamped`, which brings it into its range.

mod budget;
mod light;
mod mesh;
mod range;
mod shared;
mod sky;
mod volume;

pub use budget::VoxelGiBudget;
pub use light::{Bounces, Solver, VoxelLight};
pub use mesh::{MeshVoxelMaterial, NotVoxelized, VoxelGiLight};
pub use shared::{Receiver, VoxelAlbedo, VoxelGiSettings, Voxelizer};
pub use sky::Sky;
pub use volume::{Follow, FollowTemplate, VoxelGiVolume, VoxelGiVolumeTemplate};

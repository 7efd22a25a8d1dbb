//! The scene as the voxeliser sees it: meshes, surfaces and lamps, whether a camera sees them or
//! not.

pub(crate) mod extract;
pub(crate) mod lights;
pub(crate) mod surface;

pub use surface::{MeanColors, VoxelMaterial, VoxelSurface};

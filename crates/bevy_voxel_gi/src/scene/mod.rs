//! The scene as the voxeliser sees it: meshes, surfaces and lamps, whether a camera sees them or
//! not.

pub(crate) mod extract;
pub(crate) mod lights;
mod mean;
mod order;
pub(crate) mod surface;
pub(crate) mod table;
pub(crate) mod unknown;

pub use mean::MeanColors;
pub use surface::{VoxelMaterial, VoxelSurface};
pub use table::MeshSurface;

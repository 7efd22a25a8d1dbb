//! The scene to voxelise: meshes, surfaces and lights, inside a camera's view or not.

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

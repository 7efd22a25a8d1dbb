//! The scene to voxelise: meshes, surfaces and lights, inside a camera's view or not.

pub(crate) mod extract;
pub(crate) mod lights;
mod material_order;
pub(crate) mod material_table;
mod mean_color;
pub(crate) mod unknown_materials;
pub(crate) mod voxel_material;

pub use material_table::MeshVoxelMaterial;
pub use mean_color::MeanColors;
pub use voxel_material::{AsVoxelMaterial, VoxelMaterial};

//! Components for meshes.

use bevy::prelude::*;

/// Excludes a mesh from voxelisation: it does not block or reflect light, though it still receives it.
#[derive(Component, Reflect, Clone, Copy, Debug, Default)]
#[reflect(Component, Default, Clone)]
pub struct NotVoxelized;

/// Overrides the [`VoxelMaterial`](crate::VoxelMaterial) that a mesh gets from its material.
///
/// This is for materials whose textures the plugin cannot read, such as compressed ones, and for custom
/// shaders. Transparency remains that of the material; a material without a
/// [`VoxelMaterialPlugin`](crate::VoxelMaterialPlugin) is opaque and emits nothing unless it is said here.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone)]
pub struct MeshVoxelMaterial {
    /// Mean diffuse reflectance of the mesh, linear, 0 to 1. Default `None`: the material's.
    pub albedo: Option<Vec3>,
    /// Opaque fraction of its area, 0 to 1: below 1 where an alpha mask cuts holes. Default `None`: the
    /// material's.
    pub coverage: Option<f32>,
    /// Mean emission of the mesh, in the units of `StandardMaterial::emissive` and with the material's
    /// `emissive_exposure_weight`. Default `None`: the material's.
    pub emissive: Option<LinearRgba>,
}

//! Components for meshes.

use bevy::prelude::*;

/// Excludes a mesh from voxelisation: it does not block or reflect light, though it still receives it.
#[derive(Component, Reflect, Clone, Copy, Debug, Default)]
#[reflect(Component, Default, Clone)]
pub struct NotVoxelized;

/// Overrides the [`VoxelMaterial`](crate::VoxelMaterial) that a mesh gets from its material.
///
/// This is for custom shaders, and for what should give another light than it shows. Transparency remains that of the
/// material; a material without a
/// [`VoxelMaterialPlugin`](crate::VoxelMaterialPlugin) is opaque and emits nothing unless it is said here.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component)]
pub struct MeshVoxelMaterial {
    /// Diffuse reflectance of all of the mesh, linear, 0 to 1. Default `None`: the material's.
    pub albedo: Option<Vec3>,
    /// Opaque fraction of its area, 0 to 1: below 1 where an alpha mask cuts holes. Default `None`: the
    /// material's.
    pub coverage: Option<f32>,
    /// Emission of all of the mesh, in the units of `StandardMaterial::emissive` and with the material's
    /// `emissive_exposure_weight`. Default `None`: the material's.
    pub emissive: Option<LinearRgba>,
}

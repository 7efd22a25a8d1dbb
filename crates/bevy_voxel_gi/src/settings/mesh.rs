//! Components for meshes and lights.

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
#[reflect(Component, Default, Clone)]
pub struct MeshVoxelMaterial {
    /// Diffuse reflectance of all of the mesh, linear, 0 to 1. Default `None`: the material's.
    pub albedo: Option<Vec3>,
    /// Opaque fraction of its area, 0 to 1: below 1 where an alpha mask cuts holes. Default `None`: the
    /// material's.
    pub coverage: Option<f32>,
    /// Emission of all of the mesh, in the units of `StandardMaterial::emissive` and with the material's
    /// `emissive_exposure_weight`. Default `None`: the material's.
    pub emissive: Option<LinearRgba>,
    /// Factor of what the mesh emits into volumes, at least 0; its own picture is as before. Default `None`: 1.
    pub emission_factor: Option<f32>,
}

/// How much a light gives to volumes: on a `PointLight`, `SpotLight`, `DirectionalLight` or `RectLight`. What it lights
/// directly is as before.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Default, Clone)]
pub struct VoxelGiLight {
    /// Factor of its light in volumes, at least 0. Default 1, which is physically correct; with 0, it has no bounce and
    /// costs nothing.
    pub factor: f32,
}

impl Default for VoxelGiLight {
    fn default() -> Self {
        Self { factor: 1.0 }
    }
}

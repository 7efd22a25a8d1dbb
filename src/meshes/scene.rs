//! A scene of meshes.

use std::sync::Arc;

use bevy::math::{Affine3A, Quat, Vec2, Vec3};

use super::texture::SceneTexture;
use crate::stage::{Stage, volume_around};

/// A scene of meshes.
#[derive(Clone, Debug)]
pub struct MeshScene {
    /// The meshes, where they are.
    pub parts: Vec<ScenePart>,
    /// Lights, sky and camera.
    pub stage: Stage,
}

/// A mesh at a position.
#[derive(Clone, Debug)]
pub struct ScenePart {
    /// The geometry.
    pub mesh: Arc<SceneMesh>,
    /// The material.
    pub material: Arc<SceneMaterial>,
    /// The position of the mesh's origin in metres.
    pub translation: Vec3,
    /// The rotation about that origin.
    pub rotation: Quat,
}

impl ScenePart {
    /// From the mesh to the world.
    pub fn world_from_mesh(&self) -> Affine3A {
        Affine3A::from_rotation_translation(self.rotation, self.translation)
    }
}

/// Triangles; their front sides are counter-clockwise.
#[derive(Clone, Debug, Default)]
pub struct SceneMesh {
    /// Positions in metres.
    pub positions: Vec<Vec3>,
    /// Unit normals, as many as positions.
    pub normals: Vec<Vec3>,
    /// Texture coordinates, as many as positions.
    pub uvs: Vec<Vec2>,
    /// Three for each triangle.
    pub indices: Vec<u32>,
}

/// A Lambertian material.
#[derive(Clone, Debug)]
pub struct SceneMaterial {
    /// Diffuse albedo per channel, 0 to 1, where there is no texture; a factor of the texture's texels
    /// otherwise.
    pub albedo: Vec3,
    /// The albedo's texture.
    pub texture: Option<Arc<SceneTexture>>,
    /// Where the texture's alpha is below this, there is a hole.
    pub alpha_cutoff: Option<f32>,
    /// Both sides reflect light; the back is black otherwise.
    pub is_double_sided: bool,
    /// Radiance that the front emits, in cd/m²; a factor of the texels of `emissive_texture`, if there is one.
    pub emission: Vec3,
    /// The emission's texture.
    pub emissive_texture: Option<Arc<SceneTexture>>,
}

impl Default for SceneMaterial {
    /// A single-sided white without textures.
    fn default() -> Self {
        Self {
            albedo: Vec3::ONE,
            texture: None,
            alpha_cutoff: None,
            is_double_sided: false,
            emission: Vec3::ZERO,
            emissive_texture: None,
        }
    }
}

impl MeshScene {
    /// Corners of the bounds of all parts.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        let mut bounds = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for part in &self.parts {
            let world_from_mesh = part.world_from_mesh();
            for position in &part.mesh.positions {
                let position = world_from_mesh.transform_point3(*position);
                bounds = (bounds.0.min(position), bounds.1.max(position));
            }
        }
        bounds
    }

    /// Centre and edge of the smallest volume of this many voxels along an edge that leaves one free on each side.
    pub fn volume(&self, resolution: u32) -> (Vec3, f32) {
        volume_around(self.bounds(), resolution)
    }

    /// Number of triangles.
    pub fn triangle_count(&self) -> usize {
        let indices = self.parts.iter().map(|part| part.mesh.indices.len());
        indices.sum::<usize>() / 3
    }
}

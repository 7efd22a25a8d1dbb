//! Meshes as parts of the scene.

use std::sync::Arc;

use bevy::math::{Quat, Vec2, Vec3};

use crate::meshes::scene::{SceneMaterial, SceneMesh, ScenePart};

/// A part that is not rotated.
pub(super) fn part(mesh: SceneMesh, material: &Arc<SceneMaterial>, translation: Vec3) -> ScenePart {
    ScenePart {
        mesh: Arc::new(mesh),
        material: material.clone(),
        translation,
        rotation: Quat::IDENTITY,
    }
}

/// Texture coordinates in repetitions of a texture that is this long in metres.
pub(super) fn repeated(mut mesh: SceneMesh, metres: f32) -> SceneMesh {
    let scale = |uv: &Vec2| *uv / metres;
    mesh.uvs = mesh.uvs.iter().map(scale).collect();
    mesh
}

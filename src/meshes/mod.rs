//! Scenes of meshes with textures, in plain numbers: for Bevy and for the path tracer.

pub use crate::meshes::{
    scene::{
        MeshScene, SceneMaterial, SceneMesh, ScenePart, SceneTexture, SpawnedScene, move_to,
        spawn_mesh_scene,
    },
    triangles::trace,
};

pub mod arcade;
mod materials;
mod scene;
mod shapes;
#[cfg(test)]
mod tests;
pub mod town;
mod triangles;

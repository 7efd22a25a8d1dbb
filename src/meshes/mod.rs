//! Scenes of meshes with textures, in plain numbers: for Bevy and for the path tracer.
//!
//! | module | gives |
//! | --- | --- |
//! | `scene` | meshes, materials and where they are |
//! | `texture` | images that repeat, for both |
//! | `shapes` | boxes, arches and grids |
//! | [`arcade`] | the scene of the study of global illumination |
//! | `bvh`, `triangles` | the scene for the path tracer |
//! | `spawn` | the scene for Bevy |

pub mod arcade;
mod bvh;
mod scene;
mod shapes;
mod spawn;
#[cfg(test)]
mod tests;
mod texture;
mod triangles;

pub use scene::{MeshScene, SceneMaterial, SceneMesh, ScenePart};
pub use spawn::{SpawnedScene, move_to, spawn_mesh_scene};
pub use texture::SceneTexture;
pub use triangles::trace;

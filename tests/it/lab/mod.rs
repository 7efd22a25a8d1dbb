//! The lab's own functions: scenes, path tracing, metrics, content.

mod boxes;
mod compose;
mod content;
mod flip;
mod frames;
mod gloss;
mod heat_map;
mod meshes;
mod metrics;
mod testing;
mod voxel_gi_objects;
mod voxel_gi_stage;
mod window;

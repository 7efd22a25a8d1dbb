//! Voxelisation and light transport in plain Rust: the reference for tests of the shaders.
//!
//! | module | content |
//! | --- | --- |
//! | [`grid`] | placement and indexing of the voxels |
//! | [`overlap`] | whether a triangle overlaps a cube |
//! | [`clip`] | the area of a triangle in a voxel |
//! | [`packed_surface`] | the packed surface of a face, in 32 bits |
//! | [`voxels`] | voxelisation of triangles |
//! | [`points`] | voxelisation by random points on triangles |
//! | [`hit`] | the hit of a ray |
//! | [`mod@trace`] | ray tracing through voxels |
//! | [`surface`] | the surfaces in the voxels, and points on them |
//! | [`ray_sample`] | the light that a ray receives from its hit |
//! | [`light`] | direct light |
//! | [`rays`] | ray directions |
//! | [`gather`] | the light that arrives at a surface, or in an empty voxel |
//! | [`ray_tracing`] | bounces by ray tracing, and ambient occlusion |
//! | [`share`] | sharing between neighbouring surfaces of one plane |
//! | [`harmonics`] | spherical harmonics |
//! | [`propagate`] | light propagation from voxel to voxel |
//! | [`irradiance_field`] | the light that receivers sample |
//! | [`dividers`] | the same without light from beyond thin walls |
//! | [`visibility`] | the same from visible voxels only |
//! | [`specular`] | the specular light of rough surfaces |
//! | [`noise`] | the noise of light on flat walls |
//!
//! Comparison with path tracing, at 32^3, 24 frames, for the scenes `cornell_point`, `colonnade` and
//! `sunlit_room` (mean difference over the mean, and its bias; see `tests/reference/truth.rs`):
//!
//! | solver | error | bias |
//! | --- | --- | --- |
//! | [`RayTracing`], 32 rays a frame | 2.3%, 2.4%, 3.4% | +0.2%, +0.4%, -0.2% |
//! | [`Propagation`], 128 steps | 39%, 19%, 34% | +31%, +10%, +30% |
//! | the thesis's ray marching and reconstruction, 256 rays | 11.0%, 8.0%, 9.7% | -1.7%, -5.7%, -1.1% |

pub mod clip;
pub mod dividers;
pub mod gather;
pub mod grid;
pub mod harmonics;
pub mod hit;
pub mod irradiance_field;
pub mod light;
pub mod noise;
pub mod overlap;
pub mod packed_surface;
mod parallel;
pub mod points;
pub mod propagate;
pub mod ray_sample;
pub mod ray_tracing;
pub mod rays;
pub mod share;
pub mod specular;
pub mod surface;
pub mod trace;
pub mod visibility;
pub mod voxels;

pub use grid::{FACES, VolumeGrid};
pub use irradiance_field::IrradianceField;
pub use light::Light;
pub use propagate::{Propagation, PropagationSettings};
pub use ray_tracing::{RayTracing, RayTracingSettings, SETTLE, ambient_occlusion};
pub use voxels::{Material, Triangle, Voxels};

//! Voxelisation and light transport in plain Rust: the reference for tests of the shaders.
//!
//! | module | content |
//! | --- | --- |
//! | [`grid`] | placement and indexing of the voxels |
//! | [`overlap`] | whether a triangle overlaps a cube, and its area there |
//! | [`packed_surface`] | the packed surface of a face, in 32 bits |
//! | [`voxels`] | voxelisation of triangles, by random points on them, too |
//! | [`mod@trace`] | ray tracing through voxels, and the light that a ray receives from its hit |
//! | [`surface`] | the surfaces in the voxels, and points on them |
//! | [`light`] | direct light |
//! | [`rays`] | ray directions |
//! | [`gather`] | the light that arrives at a surface, or in an empty voxel |
//! | [`ray_tracing`] | bounces by ray tracing, and ambient occlusion |
//! | [`share`] | sharing between neighbouring surfaces of one plane |
//! | [`propagate`] | light propagation from voxel to voxel in spherical harmonics |
//! | [`irradiance_field`] | the light that receivers sample, of all voxels or of visible ones, and the specular light of rough surfaces |
//! | [`dividers`] | the same without light from beyond thin walls |
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

pub mod dividers;
pub mod gather;
pub mod grid;
pub mod irradiance_field;
pub mod light;
pub mod noise;
pub mod overlap;
pub mod packed_surface;
pub mod propagate;
pub mod ray_tracing;
pub mod share;
pub mod surface;
pub mod trace;
pub mod voxels;

pub use gather::rays;
pub use grid::{FACES, VolumeGrid};
pub use irradiance_field::IrradianceField;
pub use light::Light;
pub use propagate::{Propagation, PropagationSettings};
pub use ray_tracing::{RayTracing, RayTracingSettings, SETTLE, ambient_occlusion};
pub use voxels::{Material, Triangle, Voxels};

/// Runs a function for each of `count` indices, on all cores. On the web there is one thread.
fn each<T: Send>(count: usize, run: impl Fn(usize) -> T + Sync) -> Vec<T> {
    if cfg!(target_arch = "wasm32") {
        return (0..count).map(run).collect();
    }
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get());
    let share = count.div_ceil(threads).max(1);
    let run = &run;
    std::thread::scope(|scope| {
        let parts: Vec<_> = (0..count)
            .step_by(share)
            .map(|from| {
                scope.spawn(move || (from..count.min(from + share)).map(run).collect::<Vec<_>>())
            })
            .collect();
        parts
            .into_iter()
            .flat_map(|part| part.join().expect("a worker panicked"))
            .collect()
    })
}

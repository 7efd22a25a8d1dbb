//! Voxelisation and light transport in plain Rust: the reference for tests of the shaders.
//!
//! | module | content |
//! | --- | --- |
//! | [`grid`] | placement and indexing of the voxels |
//! | [`overlap`] | whether a triangle overlaps a cube |
//! | [`key`] | the packed surface of a face, in 32 bits |
//! | [`voxels`] | voxelisation of triangles |
//! | [`mod@trace`] | ray tracing through voxels |
//! | [`surface`] | the surfaces in the voxels, and points on them |
//! | [`seen`] | the light that a ray receives from its hit |
//! | [`light`] | direct light |
//! | [`rays`] | ray directions |
//! | [`gather`] | the light that arrives at a surface, or in an empty voxel |
//! | [`march`] | bounces by ray tracing, and ambient occlusion |
//! | [`sh`] | spherical harmonics |
//! | [`propagate`] | light propagation from voxel to voxel |
//! | [`field`] | the light that receivers sample |
//!
//! Comparison with path tracing, at 32^3, 24 frames, for the scenes `cornell_point`, `colonnade` and
//! `sunlit_room` (mean difference over the mean, and its bias; see `tests/reference/truth.rs`):
//!
//! | solver | error | bias |
//! | --- | --- | --- |
//! | [`March`], 32 rays a frame | 2.5%, 2.3%, 4.0% | +0.3%, +0.3%, -0.4% |
//! | [`Propagation`], 128 steps | 39%, 19%, 34% | +31%, +10%, +30% |
//! | the thesis's ray marching and reconstruction, 256 rays | 11.0%, 8.0%, 9.7% | -1.7%, -5.7%, -1.1% |

pub mod field;
pub mod gather;
pub mod grid;
pub mod key;
pub mod light;
pub mod march;
pub mod overlap;
pub mod propagate;
pub mod rays;
pub mod seen;
pub mod sh;
pub mod surface;
pub mod trace;
pub mod voxels;

pub use field::Field;
pub use grid::{FACES, VolumeGrid};
pub use light::Light;
pub use march::{March, MarchSettings, ambient_occlusion};
pub use propagate::{Propagation, PropagationSettings};
pub use voxels::{Material, Triangle, Voxels};

/// Runs a function for each of `count` indices, on all cores.
fn each<T: Send>(count: usize, run: impl Fn(usize) -> T + Sync) -> Vec<T> {
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

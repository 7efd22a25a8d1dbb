//! Voxelisation, light and its transport in plain Rust: what the shaders are tested against.

pub mod field;
pub mod gather;
pub mod grid;
pub mod key;
pub mod light;
pub mod march;
pub mod overlap;
pub mod propagate;
pub mod rays;
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

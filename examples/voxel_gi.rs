//! A room in which light bounces, beside what its lights alone show; the Cornell box beside its
//! path-traced picture.
//!
//! `cargo run --release --example voxel_gi` opens a window;
//! `-- --headless out --set scene=cornell` writes pictures and figures instead.

use std::process::ExitCode;

use bevy_frugal_lab::{runner, scenes::voxel_gi::VoxelGi};

fn main() -> ExitCode {
    runner::run(&VoxelGi)
}

//! Wavelet textures of 2 to 5 bits per pixel beside the originals, in a lit room.
//!
//! `cargo run --release --example wavelet_tex` opens a window;
//! `-- --headless out --image photo.png` writes pictures and figures instead.

use std::process::ExitCode;

use bevy_frugal_lab::{runner, scenes::wavelet_tex::WaveletTex};

fn main() -> ExitCode {
    runner::run(&WaveletTex)
}

//! Diffuse and specular light of two lights in one target instead of two.
//!
//! `cargo run --release --example deferred_accumulation` opens a window;
//! `-- --headless out --set method=specular_luminance` writes pictures of the shortcut.

use std::process::ExitCode;

use bevy_frugal_lab::{runner, scenes::deferred_accumulation::DeferredAccumulation};

fn main() -> ExitCode {
    runner::run(&DeferredAccumulation)
}

//! The frame buffer in fewer bytes beside Bevy's own, or the error between them.
//!
//! `cargo run --release --example ycocg_fb` opens a window;
//! `-- --headless out --set scene=foliage` writes pictures and figures instead.

use std::process::ExitCode;

use bevy_frugal_lab::{runner, scenes::ycocg_fb::YCoCgFb};

fn main() -> ExitCode {
    runner::run(&YCoCgFb)
}

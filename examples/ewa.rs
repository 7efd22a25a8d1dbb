//! A tunnel without end or a game's floor, filtered by one method on each side of the line.
//!
//! `cargo run --release --example ewa` opens a window;
//! `-- --headless out --set place=floor --set after=approximate` writes pictures instead.

use std::process::ExitCode;

use bevy_frugal_lab::{runner, scenes::ewa::Ewa};

fn main() -> ExitCode {
    runner::run(&Ewa)
}

//! A hall with all four plugins, each with a switch, beside Bevy alone.
//!
//! `cargo run --release --example all_together` opens a window;
//! `-- --headless out --set ewa=false` writes pictures instead.

use std::process::ExitCode;

use bevy_frugal_lab::{runner, scenes::all_together::AllTogether};

fn main() -> ExitCode {
    runner::run(&AllTogether)
}

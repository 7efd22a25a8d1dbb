//! Measures what a plugin costs and what it gains: accuracy, memory and time.
//!
//! `cargo run --release -p bevy_frugal_studies -- wavelet_tex --quick` writes
//! `target/tradeoff/wavelet_tex.json`, a chart and a report, which it also prints.

use std::process::ExitCode;

fn main() -> ExitCode {
    bevy_frugal_studies::run()
}

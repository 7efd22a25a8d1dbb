//! All example scenes, in a window or as a page of pictures.
//!
//! `cargo run --release --example gallery` opens a window;
//! with `-- --headless out` it writes the pictures and `index.html` into the folder `out`.

use std::process::ExitCode;

fn main() -> ExitCode {
    bevy_frugal_lab::gallery::run(bevy_frugal_lab::scenes::ALL)
}

//! `wavelet-tex`: encodes images as wavelet textures, decodes them, and measures what it cost.

mod args;
mod compare;
mod decode;
mod encode;
mod error;
mod files;
mod info;
mod picture;

use std::{
    io::{self, Write},
    process::ExitCode,
};

use args::{Cli, Command};
use clap::Parser;

fn main() -> ExitCode {
    let report = match Cli::parse().command {
        Command::Encode(args) => encode::run(&args),
        Command::Decode(args) => decode::run(&args),
        Command::Info(args) => info::run(&args),
        Command::Compare(args) => compare::run(&args),
    };
    // Not `println!` and `eprintln!`: they panic when the reader has gone.
    match report {
        Ok(report) => match writeln!(io::stdout(), "{report}") {
            Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
                let _ = writeln!(io::stderr(), "error: standard output: {error}");
                ExitCode::FAILURE
            }
            _ => ExitCode::SUCCESS,
        },
        Err(error) => {
            let _ = writeln!(io::stderr(), "error: {error}");
            error.exit_code()
        }
    }
}

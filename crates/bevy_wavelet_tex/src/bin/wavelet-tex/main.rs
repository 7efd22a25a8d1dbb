//! The tool `wavelet-tex`, which encodes images as wavelet textures, decodes them, and measures
//! their quality and their cost.

mod args;
mod batch;
mod bench;
mod compare;
mod decode;
mod encode;
mod error;
mod files;
mod gltf;
mod image_file;
mod info;
mod inputs;
mod ktx2;
mod picture;
mod plan;
mod roles;
mod settings;

use std::{
    io::{self, Write},
    process::ExitCode,
};

use args::{Cli, Command};
use batch::Report;
use clap::Parser;
use error::Error;

fn main() -> ExitCode {
    let cli = Cli::parse();
    if let Some(threads) = cli.threads {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.into());
        pool.build_global().expect("nothing has used threads yet");
    }
    let report: Result<Report, Error> = match cli.command {
        Command::Encode(args) => encode::run(&args),
        Command::Decode(args) => decode::run(&args),
        Command::Info(args) => info::run(&args),
        Command::Compare(args) => compare::run(&args).map(|text| (text, Ok(()))),
        Command::Bench(args) => bench::run(&args),
    };
    let (text, result) = match report {
        Ok((text, result)) => (text, result),
        Err(error) => (String::new(), Err(error)),
    };
    // `println!` and `eprintln!` panic when the reader has closed the pipe.
    if !text.is_empty()
        && let Err(error) = writeln!(io::stdout(), "{text}")
        && error.kind() != io::ErrorKind::BrokenPipe
    {
        let _ = writeln!(io::stderr(), "error: standard output: {error}");
        return ExitCode::FAILURE;
    }
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            let _ = writeln!(io::stderr(), "error: {error}");
            error.exit_code()
        }
    }
}

//! The tool `wavelet-tex`, which encodes images as wavelet textures, decodes them, and measures
//! their quality and their cost.

mod args;
mod batch;
mod encode;
mod files;
mod measure;
mod picture;
mod plan;
mod settings;
mod textures;

use std::{
    fmt::Display,
    io::{self, Write},
    path::{Path, PathBuf},
    process::ExitCode,
};

use args::{Cli, Command};
use batch::Report;
use clap::Parser;
use thiserror::Error;

fn main() -> ExitCode {
    let cli = Cli::parse();
    if let Some(threads) = cli.threads {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.into());
        pool.build_global().expect("nothing has used threads yet");
    }
    let report: Result<Report, Error> = match cli.command {
        Command::Encode(args) => encode::run(&args),
        Command::Decode(args) => textures::decode(&args),
        Command::Info(args) => textures::info(&args),
        Command::Compare(args) => measure::compare(&args).map(|text| (text, Ok(()))),
        Command::Bench(args) => measure::bench(&args),
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

/// The reason why a command failed.
#[derive(Debug, Error)]
enum Error {
    /// A file could not be read, written or processed.
    #[error("{}: {problem}", .path.display())]
    File {
        /// Path of the file.
        path: PathBuf,
        /// The problem, and the remedy where there is one.
        problem: String,
    },
    /// Some of several files failed, and their errors have been printed.
    #[error("{failed} of {of} files failed")]
    Batch {
        /// The number of failed files.
        failed: usize,
        /// Total number of files.
        of: usize,
    },
    /// The arguments contradict each other.
    #[error("{0}\n\nFor more information, try '--help'.")]
    Usage(String),
}

impl Error {
    fn file(path: &Path, problem: impl Display) -> Self {
        Self::File {
            path: path.to_path_buf(),
            problem: problem.to_string(),
        }
    }

    /// 1 for failures, 2 for wrong usage, which is the convention of clap.
    fn exit_code(&self) -> ExitCode {
        let is_usage = matches!(self, Self::Usage(_));
        ExitCode::from(if is_usage { 2 } else { 1 })
    }
}

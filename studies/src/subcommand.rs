//! The `main` of a word on the command line of `tradeoff`.

use std::{error::Error, ffi::OsString, process::ExitCode};

use clap::Parser;

/// Parses the arguments after the word and does what they ask for. `name` is the program with the word, as its help
/// shows it.
///
/// The exit code is 0 for success, 1 for a failure and 2 for a wrong command line; the reason is on the standard error
/// output.
pub fn subcommand<Options: Parser, E: Error>(
    name: &str,
    arguments: impl Iterator<Item = OsString>,
    run: impl FnOnce(&Options) -> Result<(), E>,
) -> ExitCode {
    let name = [OsString::from(name)];
    let options = Options::parse_from(name.into_iter().chain(arguments));
    match run(&options) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

//! From the command line to an exit code.

use std::process::ExitCode;

use indicatif::ProgressBar;

use super::{Options, RunError, Scene, render_headless, window};

/// Exit code for a command line that cannot be followed, as clap's.
const USAGE: u8 = 2;

/// The `main` of an example: parses the command line and runs `scene`.
///
/// Exit code 0 for success, 1 for a failure and 2 for a wrong command line; the reason is on the
/// standard error output.
pub fn run(scene: &'static dyn Scene) -> ExitCode {
    let matches = Options::command(scene).get_matches();
    let options = match Options::from_matches(&matches) {
        Ok(options) => options,
        Err(error) => error.exit(),
    };
    let result = match &options.headless {
        Some(folder) => {
            let progress = ProgressBar::hidden();
            render_headless(scene, &options, folder, &progress)
                .map(|outcome| println!("{}", outcome.json_line()))
        }
        None => window::open(scene, &options, None),
    };
    exit_code(result)
}

pub fn exit_code(result: Result<(), RunError>) -> ExitCode {
    let Err(error) = result else {
        return ExitCode::SUCCESS;
    };
    eprintln!("error: {error}");
    match error {
        RunError::Setting(_) | RunError::NoScene { .. } => ExitCode::from(USAGE),
        _ => ExitCode::FAILURE,
    }
}

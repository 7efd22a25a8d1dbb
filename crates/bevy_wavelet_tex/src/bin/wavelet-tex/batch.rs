//! Processing of several files, some of which can fail.

use indicatif::{ProgressBar, ProgressStyle};

use crate::{error::Error, inputs::Input};

/// The output of a command, which is not empty even where a part of the command failed, and its
/// result.
pub type Report = (String, Result<(), Error>);

/// Makes a progress bar. indicatif hides it where standard error is not a terminal.
pub fn bar(what: &str) -> ProgressBar {
    let template = format!("{{spinner}} {{bar:40}} {{pos}} of {{len}} {what} {{msg}}");
    ProgressBar::no_length()
        .with_style(ProgressStyle::with_template(&template).expect("a good template"))
}

/// Calls `each` for every input. A failure does not stop the others.
///
/// Returns the results of the inputs that succeeded, and an error that names those that failed.
pub fn run<T>(
    inputs: &[Input],
    mut each: impl FnMut(&Input, &ProgressBar) -> Result<T, Error>,
) -> (Vec<T>, Result<(), Error>) {
    let bar = bar("files");
    bar.set_length(inputs.len() as u64);
    bar.enable_steady_tick(std::time::Duration::from_millis(100));
    let mut done = Vec::new();
    let mut failed = Vec::new();
    for input in inputs {
        bar.set_message(input.relative.display().to_string());
        match each(input, &bar) {
            Ok(result) => done.push(result),
            Err(error) => failed.push(error),
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    let failure = match failed.len() {
        0 => Ok(()),
        1 if inputs.len() == 1 => Err(failed.remove(0)),
        _ => Err(Error::Batch {
            failed,
            of: inputs.len(),
        }),
    };
    (done, failure)
}

//! Many files, of which some may be bad.

use indicatif::{ProgressBar, ProgressStyle};

use crate::{error::Error, inputs::Input};

/// A bar that only a terminal sees: indicatif hides it where standard error is none.
pub fn bar(what: &str) -> ProgressBar {
    let template = format!("{{spinner}} {{bar:40}} {{pos}} of {{len}} {what} {{msg}}");
    ProgressBar::no_length()
        .with_style(ProgressStyle::with_template(&template).expect("a good template"))
}

/// Does the same with every input. A failure stops no other; in the end all are named.
///
/// The results of those that went well, and the failure of the rest.
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

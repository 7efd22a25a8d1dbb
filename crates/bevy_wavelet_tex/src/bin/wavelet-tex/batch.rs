//! Processing of several files, some of which can fail.

use std::{
    cell::RefCell,
    io::{self, Write},
    path::Path,
};

use indicatif::{ProgressBar, ProgressStyle};

use crate::Error;

/// What a command has left to print at its end, and its result.
pub type Report = (String, Result<(), Error>);

/// Makes a progress bar. indicatif hides it where standard error is not a terminal.
pub fn bar(what: &str) -> ProgressBar {
    let template = format!("{{spinner}} {{bar:40}} {{pos}} of {{len}} {what} {{msg}}");
    ProgressBar::no_length()
        .with_style(ProgressStyle::with_template(&template).expect("a good template"))
}

/// What the work on one of several files has at hand.
pub struct Batch {
    bar: ProgressBar,
    /// The reason why standard output takes no more.
    closed: RefCell<Option<io::Error>>,
}

impl Batch {
    /// Prints a line to standard output.
    pub fn say(&self, line: &str) {
        let mut closed = self.closed.borrow_mut();
        if closed.is_none() {
            let written = self.bar.suspend(|| writeln!(io::stdout(), "{line}"));
            *closed = written.err();
        }
    }

    /// Prints a warning to standard error.
    pub fn warn(&self, path: &Path, problem: &str) {
        self.bar.suspend(|| warn(path, problem));
    }

    fn complain(&self, line: &str) {
        let _ = self.bar.suspend(|| writeln!(io::stderr(), "{line}"));
    }
}

/// Prints a warning to standard error, where no progress is shown.
pub fn warn(path: &Path, problem: &str) {
    let _ = writeln!(io::stderr(), "warning: {}: {problem}", path.display());
}

/// Calls `each` for every item, in order. A failure does not stop the others. `errors` are those that
/// happened before, and `name` names an item while it is in work.
///
/// Returns the results of the items that succeeded, and an error that counts those that failed. Errors are
/// printed as they happen where there are several items.
pub fn run<I, T>(
    items: &[I],
    errors: Vec<Error>,
    name: impl Fn(&I) -> &Path,
    mut each: impl FnMut(&I, &Batch) -> Result<T, Error>,
) -> (Vec<T>, Result<(), Error>) {
    let of = items.len() + errors.len();
    let batch = Batch {
        bar: bar("files"),
        closed: RefCell::default(),
    };
    batch.bar.set_length(of as u64);
    batch
        .bar
        .enable_steady_tick(std::time::Duration::from_millis(100));
    let mut done = Vec::new();
    let mut failed = Vec::new();
    let mut fail = |error: Error| {
        if of > 1 {
            batch.complain(&format!("error: {error}"));
        }
        failed.push(error);
        batch.bar.inc(1);
    };
    errors.into_iter().for_each(&mut fail);
    for item in items {
        batch.bar.set_message(name(item).display().to_string());
        match each(item, &batch) {
            Ok(result) => {
                done.push(result);
                batch.bar.inc(1);
            }
            Err(error) => fail(error),
        }
    }
    batch.bar.finish_and_clear();
    let closed = batch.closed.take();
    if let Some(error) = closed.filter(|e| e.kind() != io::ErrorKind::BrokenPipe) {
        return (done, Err(Error::file(Path::new("standard output"), error)));
    }
    let failure = match failed.len() {
        0 => Ok(()),
        1 if of == 1 => Err(failed.remove(0)),
        failed => Err(Error::Batch { failed, of }),
    };
    (done, failure)
}

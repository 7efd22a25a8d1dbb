//! Errors of the commands, and their exit codes.

use std::{
    fmt::Display,
    path::{Path, PathBuf},
    process::ExitCode,
};

use thiserror::Error;

/// The reason why a command failed.
#[derive(Debug, Error)]
pub enum Error {
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
    pub fn file(path: &Path, problem: impl Display) -> Self {
        Self::File {
            path: path.to_path_buf(),
            problem: problem.to_string(),
        }
    }

    /// 1 for failures, 2 for wrong usage, which is the convention of clap.
    pub fn exit_code(&self) -> ExitCode {
        let is_usage = matches!(self, Self::Usage(_));
        ExitCode::from(if is_usage { 2 } else { 1 })
    }
}

//! What can go wrong, and the exit code that says so.

use std::{
    fmt::Display,
    path::{Path, PathBuf},
    process::ExitCode,
};

use thiserror::Error;

/// Why a command failed.
#[derive(Debug, Error)]
pub enum Error {
    /// Something is wrong with a file.
    #[error("{}: {problem}", .path.display())]
    File {
        /// Which.
        path: PathBuf,
        /// What, and the remedy where there is one.
        problem: String,
    },
    /// Some of many files failed.
    #[error("{} of {of} files failed:{}", .failed.len(), listed(.failed))]
    Batch {
        /// Their failures.
        failed: Vec<Error>,
        /// Files there were.
        of: usize,
    },
    /// The arguments do not make sense together.
    #[error("{0}\n\nFor more information, try '--help'.")]
    Usage(String),
}

fn listed(errors: &[Error]) -> String {
    errors.iter().map(|error| format!("\n  {error}")).collect()
}

impl Error {
    pub fn file(path: &Path, problem: impl Display) -> Self {
        Self::File {
            path: path.to_path_buf(),
            problem: problem.to_string(),
        }
    }

    /// 1 for failures, 2 for usage, as clap has it.
    pub fn exit_code(&self) -> ExitCode {
        match self {
            Self::File { .. } | Self::Batch { .. } => ExitCode::from(1),
            Self::Usage(_) => ExitCode::from(2),
        }
    }
}

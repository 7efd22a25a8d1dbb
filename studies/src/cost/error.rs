//! Why there is no figure.

use std::{io, path::PathBuf};

use thiserror::Error;

use bevy_frugal_lab::headless::HeadlessError;

/// Why there is no figure.
#[derive(Debug, Error)]
pub enum CostError {
    /// The driver is not there, or too old; what to do about it.
    #[error("{0}")]
    NoDriver(String),
    /// What was to be compiled or measured failed; why.
    #[error("on the GPU that is not there: {0}")]
    Failed(String),
    /// The app could not be built, or a pipeline failed.
    #[error(transparent)]
    App(#[from] HeadlessError),
    /// A file could not be read or written.
    #[error("`{}`: {source}", .path.display())]
    File {
        /// Its path.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
}

//! What a study is.

use std::{
    error::Error,
    path::{Path, PathBuf},
};

use bevy_wavelet_tex::codec::encoder::EncodeError;
use indicatif::ProgressBar;
use thiserror::Error as ThisError;

use super::{plan::Plan, summary::Summary};
use crate::record::{ReadError, Report, WriteError};
use bevy_frugal_lab::{
    boxes::TruthError, headless::HeadlessError, metrics::SizeMismatch, runner::RunError,
};

#[derive(Clone, Copy, Debug)]
pub struct Study {
    /// Name on the command line and in the records, which is the plugin's without `bevy_`.
    pub name: &'static str,
    pub measure: fn(&Plan, &ProgressBar) -> Result<Report, TradeoffError>,
    /// What a user chooses between, from its report.
    pub summary: fn(&Report) -> Summary,
    /// Tables in Markdown of what the summary leaves out; empty where there is nothing more.
    pub tables: fn(&Report) -> String,
}

impl Study {
    /// Measures, and names the plugin in each row.
    pub fn report(&self, plan: &Plan, progress: &ProgressBar) -> Result<Report, TradeoffError> {
        let mut report = (self.measure)(plan, progress)?;
        for row in &mut report.measurements {
            row.plugin = self.name.into();
        }
        Ok(report)
    }
}

#[derive(Debug, ThisError)]
pub enum TradeoffError {
    /// Nothing could be rendered.
    #[error(transparent)]
    Render(#[from] HeadlessError),
    /// An image could not be encoded.
    #[error(transparent)]
    Encode(#[from] EncodeError),
    /// A demo could not be shown.
    #[error(transparent)]
    Demo(#[from] RunError),
    /// A picture and its reference differ in size.
    #[error(transparent)]
    Compare(#[from] SizeMismatch),
    /// A name on the command line is no setting's.
    #[error("no setting is called `{name}` up to these resolutions; known: {}", .known.join(", "))]
    UnknownSetting { name: String, known: Vec<String> },
    /// A path-traced picture could not be read.
    #[error(transparent)]
    Truth(#[from] TruthError),
    /// A file could not be read or written, or a folder not made.
    #[error("`{}`: {source}", .path.display())]
    File {
        path: PathBuf,
        source: std::io::Error,
    },
    /// An earlier report could not be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The report could not be written.
    #[error(transparent)]
    Write(#[from] WriteError),
}

impl TradeoffError {
    /// Turns an error of a file or folder into one with its path.
    pub(super) fn file<E: Into<Box<dyn Error + Send + Sync>>>(path: &Path) -> impl Fn(E) -> Self {
        move |source| Self::File {
            path: path.into(),
            source: std::io::Error::other(source),
        }
    }
}

/// Prints a line above the progress bar, also where the bar is hidden.
pub(super) fn note(progress: &ProgressBar, text: &str) {
    progress.suspend(|| eprintln!("{text}"));
}

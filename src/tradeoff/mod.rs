//! What each plugin costs and what it gains: accuracy, memory and time, as a [`Report`].
//!
//! A plugin's measurements are a [`Study`], one entry of [`STUDIES`].
//!
//! | module | gives |
//! | --- | --- |
//! | [`contest`] | frame times of settings that take turns |
//! | [`options`] | the command line, and how much it makes a study measure |
//! | [`mod@wavelet_tex`] | the study of `bevy_wavelet_tex` |
//! | [`ycocg_fb`] | the study of `bevy_ycocg_fb` |
//! | [`ewa`] | the study of `bevy_ewa` |
//! | [`voxel_gi`] | the study of `bevy_voxel_gi` |
//! | `table` | the report as a short table |

pub mod contest;
pub mod ewa;
pub mod options;
mod table;
pub mod voxel_gi;
pub mod wavelet_tex;
pub mod ycocg_fb;

use std::{
    path::{Path, PathBuf},
    process::ExitCode,
};

use bevy_wavelet_tex::codec::encoder::EncodeError;
use clap::Parser;
use indicatif::{ProgressBar, ProgressStyle};
use thiserror::Error;

use crate::{
    boxes::TruthError,
    headless::HeadlessError,
    metrics::SizeMismatch,
    record::{Report, WriteError},
};
use options::{Options, Plan};

/// The studies, one a plugin.
pub const STUDIES: &[Study] = &[
    wavelet_tex::STUDY,
    ycocg_fb::STUDY,
    ewa::STUDY,
    voxel_gi::STUDY,
];

/// The measurements of one plugin.
#[derive(Clone, Copy, Debug)]
pub struct Study {
    /// What it is called on the command line, and its report.
    pub name: &'static str,
    /// Measures, and tells the bar how far it is.
    pub measure: fn(&Plan, &ProgressBar) -> Result<Report, TradeoffError>,
    /// A plot of its report as SVG, if there is one.
    pub plot: Option<fn(&Report) -> String>,
}

/// Why a study has no report.
#[derive(Debug, Error)]
pub enum TradeoffError {
    /// Nothing could be rendered.
    #[error(transparent)]
    Render(#[from] HeadlessError),
    /// An image could not be encoded.
    #[error(transparent)]
    Encode(#[from] EncodeError),
    /// A picture and its reference differ in size.
    #[error(transparent)]
    Compare(#[from] SizeMismatch),
    /// A photograph could not be read.
    #[error("cannot read `{}`: {source}", .path.display())]
    Image {
        /// Its path.
        path: PathBuf,
        /// What the decoder says.
        source: image::ImageError,
    },
    /// A path-traced picture could not be read.
    #[error(transparent)]
    Truth(#[from] TruthError),
    /// The plot could not be written.
    #[error("cannot write the plot `{}`: {source}", .path.display())]
    Plot {
        /// Its path.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The folder of the reports could not be made.
    #[error("cannot make the folder `{}`: {source}", .path.display())]
    Folder {
        /// Its path.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The report could not be written.
    #[error(transparent)]
    Write(#[from] WriteError),
}

/// The `main` of the example: measures what the command line names and writes the reports.
///
/// Exit code 0 for success, 1 for a failure and 2 for a wrong command line; the reason is on the
/// standard error output.
pub fn run() -> ExitCode {
    let options = Options::parse();
    let plan = Plan::new(options.quick);
    for study in options.studies() {
        if let Err(error) = write_report(study, &plan, &options.out) {
            eprintln!("error: {}: {error}", study.name);
            return ExitCode::FAILURE;
        }
    }
    ExitCode::SUCCESS
}

/// Measures and writes `folder/NAME.json`, and `folder/NAME.svg` where there is a plot; the table goes to the standard output.
fn write_report(study: &Study, plan: &Plan, folder: &Path) -> Result<(), TradeoffError> {
    // A folder that cannot be made should not show up after minutes of measuring.
    std::fs::create_dir_all(folder).map_err(|source| TradeoffError::Folder {
        path: folder.into(),
        source,
    })?;
    // Hidden by indicatif where standard error is no terminal.
    let progress = ProgressBar::new(0).with_prefix(study.name);
    if let Ok(style) =
        ProgressStyle::with_template("{prefix} {bar:30} {pos}/{len} {elapsed} {wide_msg}")
    {
        progress.set_style(style);
    }
    let result = (study.measure)(plan, &progress);
    progress.finish_and_clear();
    let report = result?;
    let path = folder.join(study.name).with_extension("json");
    report.write(&path)?;
    if let Some(plot) = study.plot {
        let path = path.with_extension("svg");
        std::fs::write(&path, plot(&report))
            .map_err(|source| TradeoffError::Plot { path, source })?;
    }
    print!("{}", table::table(&report));
    println!("written to {}", path.display());
    Ok(())
}

/// Says something beside the bar, also where the bar is hidden.
fn note(progress: &ProgressBar, text: &str) {
    progress.suspend(|| eprintln!("{text}"));
}

#[cfg(test)]
mod tests;

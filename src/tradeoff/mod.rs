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
//! | [`summary`] | what a user chooses between: each setting as one error and one cost |
//! | [`chart`] | a summary as a chart |
//! | [`markdown`] | summaries as a report, and as tables of advice |
//! | [`mod@csv`] | a report as comma-separated values |
//! | `table` | a report as a short table |

pub mod chart;
pub mod contest;
pub mod csv;
pub mod ewa;
pub mod markdown;
pub mod options;
pub mod summary;
mod table;
pub mod voxel_gi;
pub mod wavelet_tex;
pub mod ycocg_fb;

use std::{
    path::{Path, PathBuf},
    process::ExitCode,
    time::SystemTime,
};

use bevy_wavelet_tex::codec::encoder::EncodeError;
use clap::Parser;
use indicatif::{ProgressBar, ProgressStyle};
use thiserror::Error;

use crate::{
    boxes::TruthError,
    headless::HeadlessError,
    metrics::SizeMismatch,
    record::{ReadError, Report, WriteError},
};
use options::{Options, Plan};
use summary::Summary;

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
    /// What a user chooses between, from its report.
    pub summary: fn(&Report) -> Summary,
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
    /// A file could not be read or written, or a folder not made.
    #[error("`{}`: {source}", .path.display())]
    File {
        /// Its path.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// An earlier report could not be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The report could not be written.
    #[error(transparent)]
    Write(#[from] WriteError),
}

/// The `main` of the example: measures what the command line names and writes the reports.
///
/// Exit code 0 for success, 1 for a failure and 2 for a wrong command line; the reason is on the
/// standard error output. A study that fails does not keep the others from being measured.
pub fn run() -> ExitCode {
    let options = Options::parse();
    // A folder that cannot be made should not show up after minutes of measuring.
    if let Err(error) = make_folder(&options.out) {
        eprintln!("error: {error}");
        return ExitCode::FAILURE;
    }
    let mut chapters = String::new();
    let mut code = ExitCode::SUCCESS;
    for study in options.studies() {
        match write_report(study, &options) {
            Ok(chapter) => chapters = chapters + "\n" + &chapter,
            Err(error) => {
                eprintln!("error: {}: {error}", study.name);
                code = ExitCode::FAILURE;
            }
        }
    }
    let path = options.out.join("report.md");
    let text = format!("# What the plugins cost, and what they gain\n{chapters}");
    if let Err(error) = write(&path, &text) {
        eprintln!("error: {error}");
        return ExitCode::FAILURE;
    }
    println!("written to {}", path.display());
    code
}

/// Measures, or reads what was measured, and writes JSON, CSV and a chart; the table goes to the
/// standard output. Returns the chapter of the report.
fn write_report(study: &Study, options: &Options) -> Result<String, TradeoffError> {
    let report = match &options.from {
        Some(folder) => Report::read(folder.join(study.name).with_extension("json"))?,
        None => measured(study, options)?,
    };
    let path = options.out.join(study.name);
    report.write(path.with_extension("json"))?;
    write(&path.with_extension("csv"), &csv::csv(&report))?;
    let summary = (study.summary)(&report);
    let machine = markdown::machine(&report);
    write(&path.with_extension("svg"), &chart::svg(&summary, &machine))?;
    if let Some(document) = &options.advise {
        let text = std::fs::read_to_string(document).map_err(|source| TradeoffError::File {
            path: document.clone(),
            source,
        })?;
        if let Some(text) = markdown::renewed(&text, study.name, &markdown::advice(&summary)) {
            write(document, &text)?;
        }
    }
    print!("{}", table::table(&report));
    Ok(markdown::chapter(study.name, &summary, &report))
}

fn measured(study: &Study, options: &Options) -> Result<Report, TradeoffError> {
    // Hidden by indicatif where standard error is no terminal.
    let progress = ProgressBar::new(0).with_prefix(study.name);
    if let Ok(style) =
        ProgressStyle::with_template("{prefix} {bar:30} {pos}/{len} {elapsed} {wide_msg}")
    {
        progress.set_style(style);
    }
    let report = (study.measure)(&Plan::of(options), &progress);
    progress.finish_and_clear();
    let now = humantime::format_rfc3339_seconds(SystemTime::now()).to_string();
    Ok(Report {
        date: now.split('T').next().unwrap_or_default().into(),
        ..report?
    })
}

fn make_folder(path: &Path) -> Result<(), TradeoffError> {
    std::fs::create_dir_all(path).map_err(|source| TradeoffError::File {
        path: path.into(),
        source,
    })
}

fn write(path: &Path, text: &str) -> Result<(), TradeoffError> {
    std::fs::write(path, text).map_err(|source| TradeoffError::File {
        path: path.into(),
        source,
    })
}

/// Says something beside the bar, also where the bar is hidden.
fn note(progress: &ProgressBar, text: &str) {
    progress.suspend(|| eprintln!("{text}"));
}

#[cfg(test)]
mod tests;

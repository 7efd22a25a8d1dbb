//! The times of all plugins on the GPU that is there, by its own time stamps, in a few minutes: `tradeoff gpu`.
//!
//! It is what the thesis measured: the share of a texture unit's speed (its figure 3.25 and table 5.1), fill rate and
//! resolve (table 4.1), and the passes of global illumination (tables 6.1 and 6.2). Accuracy depends on no GPU, and is
//! in the studies. Each part is written as soon as it is measured; `reference` in its rows is the size of the pictures.
//!
//! | module | gives |
//! | --- | --- |
//! | [`options`] | the command line |
//! | [`mod@parts`] | what is measured |
//! | [`gi`] | the passes of global illumination |
//! | [`tables`] | the times as tables, for the pages |

pub mod gi;
pub mod options;
pub mod parts;
pub mod tables;

use std::{
    ffi::OsString,
    path::{Path, PathBuf},
    process::ExitCode,
    time::{Duration, Instant},
};

use indicatif::ProgressBar;

use self::{options::Options, parts::PARTS};
use super::study::TradeoffError;
use crate::{record::Report, subcommand::subcommand};

/// Where the committed figures are, relative to the repository, in a folder for each adapter.
pub const FOLDER: &str = "docs/measurements";
const FILE: &str = "gpu.json";

/// The `main` of `tradeoff gpu`, with the arguments after the word.
pub fn run(arguments: impl Iterator<Item = OsString>) -> ExitCode {
    subcommand(
        "tradeoff gpu",
        arguments,
        |options: &Options| match &options.advise {
            Some(file) => tables::renew(file),
            None => measure(options),
        },
    )
}

/// Measures part after part. One that fails does not keep the others from being measured; the last error is returned.
fn measure(options: &Options) -> Result<(), TradeoffError> {
    let start = Instant::now();
    let limit = Duration::from_secs_f64(60.0 * options.minutes.max(0.0));
    let mut report = Report::of_today();
    let progress = ProgressBar::hidden();
    let mut failure = None;
    for (name, part) in PARTS {
        for step in part.steps(options) {
            if start.elapsed() > limit {
                eprintln!("{name}: left out, {} minutes are over", options.minutes);
                continue;
            }
            match part.rows(options, step, &progress) {
                Ok((adapter, mut rows)) => {
                    report.adapter = adapter;
                    for row in &mut rows {
                        row.plugin = part.plugin.into();
                        row.reference = options.size.to_string();
                    }
                    report.measurements.extend(rows);
                    let folder = write(&report, &options.out)?;
                    let seconds = start.elapsed().as_secs();
                    println!("{name}: in {} after {seconds} s", folder.display());
                }
                Err(error) => {
                    eprintln!("error: {name}: {error}");
                    failure = Some(error);
                }
            }
        }
    }
    failure.map_or(Ok(()), Err)
}

/// Writes the figures and their tables into the adapter's folder.
fn write(report: &Report, out: &Path) -> Result<PathBuf, TradeoffError> {
    let folder = out.join(folder_name(&report.adapter.name));
    std::fs::create_dir_all(&folder).map_err(TradeoffError::file(&folder))?;
    report.write(folder.join(FILE))?;
    let text = format!(
        "# Times on a GPU\n\n{}\n\n{}",
        tables::measured_on(report),
        tables::all(report)
    );
    std::fs::write(folder.join("gpu.md"), text).map_err(TradeoffError::file(&folder))?;
    Ok(folder)
}

/// An adapter's name as that of a folder.
fn folder_name(adapter: &str) -> String {
    let words = adapter.split(|c: char| !c.is_ascii_alphanumeric());
    let words: Vec<_> = words.filter(|word| !word.is_empty()).collect();
    words.join("_").to_lowercase()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_adapters_name_is_a_folders() {
        assert_eq!(
            folder_name("AMD Radeon RX 7900 (RADV)"),
            "amd_radeon_rx_7900_radv"
        );
    }
}

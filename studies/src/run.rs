//! From the command line to the reports.

use std::{path::Path, process::ExitCode};

use clap::Parser;
use indicatif::{ProgressBar, ProgressStyle};

use super::{
    chart, demo, gpu, markdown,
    options::Options,
    study::{Study, TradeoffError},
};
use crate::{cost, record::Report};

/// The `main` of the example: measures what the command line names and writes the reports.
///
/// Exit code 0 for success, 1 for a failure and 2 for a wrong command line; the reason is on the
/// standard error output. A study that fails does not keep the others from being measured.
pub fn run() -> ExitCode {
    let words: Vec<_> = std::env::args_os().skip(1).take(1).collect();
    let arguments = std::env::args_os().skip(2);
    match words.as_slice() {
        [first, ..] if first == "cost" => return cost::run(arguments),
        [first, ..] if first == "gpu" => return gpu::run(arguments),
        [first, ..] if first == "demo" => return demo::run(arguments),
        _ => {}
    }
    let options = Options::parse();
    // A folder that cannot be made should not show up after minutes of measuring.
    if let Err(error) = std::fs::create_dir_all(&options.out) {
        eprintln!("error: `{}`: {error}", options.out.display());
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

/// Measures, or reads what was measured, and writes JSON and a chart. Returns the chapter of the
/// report.
fn write_report(study: &Study, options: &Options) -> Result<String, TradeoffError> {
    let report = match &options.from {
        Some(folder) => Report::read(folder.join(study.name).with_extension("json"))?,
        None => measured(study, options)?,
    };
    let path = options.out.join(study.name);
    report.write(path.with_extension("json"))?;
    let summary = (study.summary)(&report);
    let machine = markdown::machine(&report);
    write(&path.with_extension("svg"), &chart::svg(&summary, &machine))?;
    if let Some(document) = &options.advise {
        markdown::renew_file(document, study.name, &markdown::advice(&summary))?;
    }
    let tables = (study.tables)(&report);
    let chapter = markdown::chapter(study.name, &summary, &report) + &tables;
    println!("{chapter}");
    Ok(chapter)
}

fn measured(study: &Study, options: &Options) -> Result<Report, TradeoffError> {
    // Hidden by indicatif where standard error is no terminal.
    let progress = ProgressBar::new(0).with_prefix(study.name);
    if let Ok(style) =
        ProgressStyle::with_template("{prefix} {bar:30} {pos}/{len} {elapsed} {wide_msg}")
    {
        progress.set_style(style);
    }
    let report = study.report(&options.plan(), &progress);
    progress.finish_and_clear();
    Ok(Report {
        date: Report::of_today().date,
        ..report?
    })
}

fn write(path: &Path, text: &str) -> Result<(), TradeoffError> {
    std::fs::write(path, text).map_err(TradeoffError::file(path))
}

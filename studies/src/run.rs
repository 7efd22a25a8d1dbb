//! From the command line to the reports: what a study is, and the list of all.

use std::{
    error::Error,
    path::{Path, PathBuf},
    process::ExitCode,
};

use bevy_frugal_lab::{
    boxes::TruthError, headless::HeadlessError, metrics::SizeMismatch, runner::RunError,
};
use bevy_wavelet_tex::codec::encoder::EncodeError;
use clap::{Parser, Subcommand, builder::PossibleValuesParser};
use indicatif::{ProgressBar, ProgressStyle};
use serde::{Serialize, de::DeserializeOwned};
use thiserror::Error as ThisError;

use crate::{
    cost::{self, CostError},
    demo,
    ewa::Ewa,
    gpu, page,
    plan::{GI_SCENES, Plan},
    record::{FileError, Report},
    summary::{Summary, svg},
    voxel_gi::{VoxelGi, motion},
    wavelet_tex::WaveletTex,
    ycocg_fb::YCoCgFb,
};

/// The measurements of a plugin.
pub trait Study {
    /// Name on the command line and of its files, which is the plugin's without `bevy_`.
    const NAME: &'static str;
    /// What it measures.
    type Rows: Default + Serialize + DeserializeOwned;

    fn measure(plan: &Plan, progress: &ProgressBar) -> Result<Report<Self::Rows>, TradeoffError>;
    /// What a user chooses between.
    fn summary(rows: &Self::Rows) -> Summary;
    /// Tables in Markdown of what the summary leaves out; empty where there is nothing more.
    fn tables(_: &Self::Rows) -> String {
        String::new()
    }
}

/// A study, whatever its rows are.
pub struct AnyStudy {
    pub name: &'static str,
    /// Measures, or reads what was measured, and writes JSON and a chart. Returns the chapter of the report.
    write: fn(&Options) -> Result<String, TradeoffError>,
    /// The summary of the report in a folder.
    pub summary: fn(&Path) -> Result<Summary, FileError>,
}

/// All studies, in the order in which they are measured.
pub const STUDIES: [AnyStudy; 4] = [
    any::<WaveletTex>(),
    any::<YCoCgFb>(),
    any::<Ewa>(),
    any::<VoxelGi>(),
];

const fn any<S: Study>() -> AnyStudy {
    AnyStudy {
        name: S::NAME,
        write: write_report::<S>,
        summary: |folder| Ok(S::summary(&read::<S>(folder)?.rows)),
    }
}

/// The report of a study in a folder.
pub fn read<S: Study>(folder: &Path) -> Result<Report<S::Rows>, FileError> {
    Report::read(folder.join(S::NAME).with_extension("json"))
}

/// Stands for every study on the command line.
const ALL: &str = "all";

/// Measures what a plugin costs and what it gains: accuracy, memory and time.
#[derive(Clone, Debug, Parser)]
#[command(
    name = "tradeoff",
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true
)]
pub struct Options {
    /// Plugin to measure.
    #[arg(value_name = "PLUGIN", value_parser = PossibleValuesParser::new(names()), required = true)]
    plugin: Option<String>,
    /// Fewer images, smaller pictures and fewer repetitions.
    #[arg(long)]
    quick: bool,
    /// Leaves out volumes of more voxels along an edge: 64 take an hour on a software driver, 128 several.
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(16..))]
    max_resolution: u32,
    /// Setting of global illumination to measure, by its name in the report, and nothing else of that study; may be
    /// repeated.
    #[arg(long, value_name = "NAME")]
    setting: Vec<String>,
    /// Scene of global illumination to measure, and nothing else of that study; may be repeated.
    #[arg(long, value_name = "SCENE", value_parser = PossibleValuesParser::new(GI_SCENES))]
    scene: Vec<String>,
    /// Folder of the reports, made where it is missing.
    #[arg(long, value_name = "DIR", default_value = "target/tradeoff")]
    out: PathBuf,
    /// Measures nothing: reads the reports of an earlier run from this folder.
    #[arg(long, value_name = "DIR")]
    from: Option<PathBuf>,
    /// Renews the tables of advice on the pages with the plugins' figures, between `<!-- tradeoff PLUGIN -->` and
    /// `<!-- end -->`.
    #[arg(long)]
    advise: bool,
    #[command(subcommand)]
    other: Option<Other>,
}

/// What is measured beside the studies.
#[derive(Clone, Debug, Subcommand)]
enum Other {
    /// What the shaders cost when they are compiled for a GPU.
    Cost(cost::Options),
    /// Times on the GPU that is there.
    Gpu(gpu::Options),
    /// Times of the demos' pictures.
    Demo(demo::Options),
    /// Times of frames in which something moves, with global illumination and without.
    Motion(motion::Options),
}

impl Options {
    /// The studies that were asked for.
    pub fn studies(&self) -> impl Iterator<Item = &'static AnyStudy> {
        let plugin = self.plugin.as_deref().unwrap_or_default();
        const { &STUDIES }
            .iter()
            .filter(move |study| plugin == ALL || plugin == study.name)
    }

    /// How much the studies measure.
    fn plan(&self) -> Plan {
        let mut plan = Plan::new(self.quick);
        let most = self.max_resolution;
        plan.gi.resolutions.retain(|resolution| *resolution <= most);
        if !self.setting.is_empty() {
            plan.gi.retain_settings(&self.setting);
        }
        if !self.scene.is_empty() {
            plan.gi.retain_scenes(&self.scene);
        }
        plan
    }
}

fn names() -> impl Iterator<Item = &'static str> {
    STUDIES.map(|study| study.name).into_iter().chain([ALL])
}

/// The `main` of the program: measures what the command line names and writes the reports.
///
/// Exit code 0 for success, 1 for a failure and 2 for a wrong command line; the reason is on the
/// standard error output. A study that fails does not keep the others from being measured.
pub fn run() -> ExitCode {
    let options = Options::parse();
    let result = match &options.other {
        Some(Other::Cost(options)) => cost::measure(options).map_err(TradeoffError::from),
        Some(Other::Gpu(options)) => gpu::run(options),
        Some(Other::Demo(options)) => demo::run(options),
        Some(Other::Motion(options)) => motion::run(options),
        None => write_reports(&options),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

/// One that fails does not keep the others from being measured; the last error is returned.
fn write_reports(options: &Options) -> Result<(), TradeoffError> {
    // A folder that cannot be made should not show up after minutes of measuring.
    std::fs::create_dir_all(&options.out).map_err(TradeoffError::file(&options.out))?;
    let mut text = "# What the plugins cost, and what they gain\n".to_string();
    let mut failure = None;
    for study in options.studies() {
        match (study.write)(options) {
            Ok(chapter) => text = text + "\n" + &chapter,
            Err(error) => {
                eprintln!("error: {}: {error}", study.name);
                failure = Some(error);
            }
        }
    }
    let path = options.out.join("report.md");
    write(&path, &text)?;
    println!("written to {}", path.display());
    failure.map_or(Ok(()), Err)
}

fn write_report<S: Study>(options: &Options) -> Result<String, TradeoffError> {
    let report = match &options.from {
        Some(folder) => read::<S>(folder)?,
        None => measured::<S>(options)?,
    };
    let path = options.out.join(S::NAME);
    report.write(path.with_extension("json"))?;
    let summary = S::summary(&report.rows);
    let machine = page::machine(&report);
    write(&path.with_extension("svg"), &svg(&summary, &machine))?;
    if options.advise {
        page::renew_file(
            &page::plugin_page(S::NAME),
            S::NAME,
            &page::advice(&summary),
        )?;
    }
    let chapter = page::chapter(S::NAME, &summary, &machine) + &S::tables(&report.rows);
    println!("{chapter}");
    Ok(chapter)
}

fn measured<S: Study>(options: &Options) -> Result<Report<S::Rows>, TradeoffError> {
    // Hidden by indicatif where standard error is no terminal.
    let progress = ProgressBar::new(0).with_prefix(S::NAME);
    if let Ok(style) =
        ProgressStyle::with_template("{prefix} {bar:30} {pos}/{len} {elapsed} {wide_msg}")
    {
        progress.set_style(style);
    }
    let report = S::measure(&options.plan(), &progress);
    progress.finish_and_clear();
    Ok(report?.of_today())
}

fn write(path: &Path, text: &str) -> Result<(), TradeoffError> {
    std::fs::write(path, text).map_err(TradeoffError::file(path))
}

/// Prints a line above the progress bar, also where the bar is hidden.
pub(super) fn note(progress: &ProgressBar, text: &str) {
    progress.suspend(|| eprintln!("{text}"));
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
    #[error(transparent)]
    File(#[from] FileError),
    /// Nothing could be compiled.
    #[error(transparent)]
    Cost(#[from] CostError),
}

impl TradeoffError {
    /// Turns an error of a file or folder into one with its path.
    pub(super) fn file<E: Into<Box<dyn Error + Send + Sync>>>(path: &Path) -> impl Fn(E) -> Self {
        move |source| Self::File(FileError::new(path, source))
    }
}

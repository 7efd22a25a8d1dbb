//! What the plugins cost on a GPU as its own compiler says, without owning the GPU.
//!
//! Mesa's AMD driver compiles for a GPU that is not there exactly as for one that is, and prints what
//! each shader takes: instructions, registers, waves per SIMD. It executes nothing, so there are no
//! pictures and no times, and how often a loop or a branch runs is not known. The figures are the same
//! on every machine with the same version of Mesa, except the time to compile.
//!
//! Vulkan has such statistics of every driver (`VK_KHR_pipeline_executable_properties`), but only of pipelines
//! created with `VK_PIPELINE_CREATE_CAPTURE_STATISTICS_BIT_KHR`, which wgpu-hal does not set; it would take Vulkan
//! pipelines of our own beside wgpu's, so they are left out.
//!
//! A program starts itself again under that driver. There it builds, for each
//! [`Configuration`](configurations::Configuration) of a plugin and for Bevy alone, small scenes with one material each ([`mod@app`]),
//! and compiles every pipeline of interest a second time, one at a time ([`pipelines`]): what the driver
//! prints between two marks belongs to the pipeline whose name is in the marks. So no
//! order of compiling is assumed.

use std::path::PathBuf;

use bevy_frugal_lab::headless::HeadlessError;
use clap::Parser;
use thiserror::Error;

use self::{configurations::configurations, record::Budget};
use crate::record::FileError;

pub mod app;
pub mod configurations;
pub mod cpu;
pub mod fetches;
pub mod pipelines;
pub mod record;
pub mod tables;

/// The command line of `tradeoff cost`.
#[derive(Clone, Debug, Parser)]
pub struct Options {
    /// GPUs to compile for, as Mesa names them: navi31 (RDNA 3), navi21 (RDNA 2), vega10 (GCN 5).
    #[arg(long, value_name = "GPU,..", value_delimiter = ',', default_values = ["navi31", "navi21", "vega10"])]
    gpu: Vec<String>,
    /// Only this plugin.
    #[arg(long, value_name = "PLUGIN")]
    plugin: Option<String>,
    /// Folder of the figures, made where it is missing.
    #[arg(long, value_name = "DIR", default_value = "target/tradeoff/cost")]
    out: PathBuf,
    /// Samples the CPU's time of frames on the first GPU with Linux's `perf` instead, and names the plugins' systems.
    #[arg(long)]
    systems: bool,
    /// Counts texture fetches on the adapter that is there instead of compiling.
    #[arg(long, conflicts_with = "systems")]
    fetches: bool,
    /// Renews charts, the tables in the plugins' pages and the budget, from the figures in the folder.
    #[arg(long)]
    advise: bool,
    /// The part of the program that runs under the driver.
    #[arg(long, hide = true)]
    inside: bool,
}

/// Does what the command line asks for.
pub fn measure(options: &Options) -> Result<(), CostError> {
    if options.advise {
        let rows = record::read(&options.out)?;
        tables::renew(&rows, &options.out)?;
        tables::draw(&rows, &options.out)?;
        return Ok(Budget::read()?.renewed(&rows).write()?);
    }
    let plugin = options.plugin.as_deref();
    if options.systems {
        return cpu::measure(options.inside, &options.gpu[0], &options.out);
    }
    if options.fetches {
        return fetches::measure(plugin, &options.out);
    }
    let mut selected = configurations();
    if options.inside {
        return pipelines::print(&selected);
    }
    selected.retain(|c| c.plugin == "bevy" || plugin.is_none_or(|p| p == c.plugin));
    let mut program = pipelines::this_program();
    program.args(["cost", "--inside"]);
    let mut rows = Vec::new();
    for gpu in &options.gpu {
        eprintln!("{gpu}: compiling {} configurations", selected.len());
        rows.extend(record::beside_bevy(pipelines::compile(
            gpu, &program, &selected,
        )?));
    }
    let rows = record::renewed(&options.out, rows)?;
    record::write(&rows, &options.out)?;
    tables::draw(&rows, &options.out)?;
    for gpu in &options.gpu {
        for (plugin, _) in configurations::PLUGINS {
            let table = tables::page(&rows, gpu, plugin);
            println!("{plugin} on {gpu}: instructions (of Bevy's own), VGPRs, waves\n\n{table}");
        }
    }
    println!("written to {}", options.out.display());
    Ok(())
}

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
    #[error(transparent)]
    File(#[from] FileError),
}

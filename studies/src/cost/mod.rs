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
//! A program starts itself again under that driver ([`shim`]). There it builds, for each
//! [`Configuration`](configurations::Configuration) of a plugin and for Bevy alone, small scenes with one material each ([`mod@app`]),
//! and compiles every pipeline of interest a second time, one at a time ([`pipelines`]): what the driver
//! prints between two marks belongs to the pipeline whose name is in the marks ([`statistics`]). So no
//! order of compiling is assumed.
//!
//! | module | gives |
//! | --- | --- |
//! | [`shim`] | starting a program under the driver |
//! | [`mod@configurations`] | what is compiled, by name |
//! | [`scene`] | what is drawn |
//! | [`skin`] | the materials |
//! | [`mod@app`] | a configuration in an app |
//! | [`pipelines`] | every pipeline of an app, compiled between marks |
//! | [`statistics`] | what the driver printed, as rows |
//! | [`mod@record`] | rows with those of Bevy beside them, in files |
//! | [`cpu`] | the CPU's time for the plugins' systems, where the GPU takes none |
//! | [`fetches`] | texture fetches of a pixel, counted on an adapter that draws |
//! | [`tables`] | tables for the plugins' pages |
//! | [`charts`] | accuracy against compiled cost |
//! | [`mod@budget`] | rows that may not grow unnoticed |

pub mod app;
pub mod budget;
pub mod charts;
pub mod configurations;
pub mod cpu;
pub mod error;
pub mod fetches;
pub mod pipelines;
pub mod record;
pub mod scene;
pub mod shim;
pub mod skin;
pub mod statistics;
pub mod tables;

use std::{ffi::OsString, path::PathBuf, process::ExitCode};

use clap::Parser;

use budget::Budget;
use configurations::configurations;
use error::CostError;

use crate::subcommand::subcommand;

/// The command line of `tradeoff cost`.
#[derive(Clone, Debug, Parser)]
#[command(name = "tradeoff cost")]
struct Options {
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

/// The `main` of `tradeoff cost`, with the arguments after the word.
pub fn run(arguments: impl Iterator<Item = OsString>) -> ExitCode {
    subcommand("tradeoff cost", arguments, measure)
}

fn measure(options: &Options) -> Result<(), CostError> {
    if options.advise {
        let rows = record::read(&options.out)?;
        record::write(&rows, &options.out)?;
        tables::renew(&rows, &options.out)?;
        charts::write(&rows, &options.out)?;
        return Budget::read()?.renewed(&rows).write();
    }
    let plugin = options.plugin.as_deref();
    if options.systems {
        return cpu::measure(options.inside, &options.gpu[0], &options.out);
    }
    if options.fetches {
        return fetches::measure(plugin, &options.out);
    }
    let mut wanted = configurations();
    if options.inside {
        return pipelines::print(&wanted);
    }
    wanted.retain(|c| c.plugin == "bevy" || plugin.is_none_or(|p| p == c.plugin));
    let mut program = shim::this_program();
    program.args(["cost", "--inside"]);
    let mut rows = Vec::new();
    for gpu in &options.gpu {
        eprintln!("{gpu}: compiling {} configurations", wanted.len());
        rows.extend(record::beside_bevy(pipelines::compile(
            gpu, &program, &wanted,
        )?));
    }
    let rows = record::renewed(&options.out, rows)?;
    record::write(&rows, &options.out)?;
    charts::write(&rows, &options.out)?;
    for gpu in &options.gpu {
        for (plugin, _) in configurations::PLUGINS {
            let table = tables::page(&rows, gpu, plugin);
            println!("{plugin} on {gpu}: instructions (of Bevy's own), VGPRs, waves\n\n{table}");
        }
    }
    println!("written to {}", options.out.display());
    Ok(())
}

//! The command line.

use std::path::PathBuf;

use clap::{Parser, builder::PossibleValuesParser};

use super::{
    plan::{GI_SCENES, Plan},
    studies::STUDIES,
    study::Study,
};

/// Stands for every study on the command line.
const ALL: &str = "all";

/// Measures what a plugin costs and what it gains: accuracy, memory and time.
#[derive(Clone, Debug, Parser)]
#[command(
    name = "tradeoff",
    after_help = "What the shaders cost when they are compiled for a GPU: tradeoff cost --help\n\
                  Times on the GPU that is there: tradeoff gpu --help\n\
                  Times of the demos' pictures: tradeoff demo --help"
)]
pub struct Options {
    /// Plugin to measure.
    #[arg(value_name = "PLUGIN", value_parser = PossibleValuesParser::new(names()))]
    pub plugin: String,
    /// Fewer images, smaller pictures and fewer repetitions.
    #[arg(long)]
    pub quick: bool,
    /// Leaves out volumes of more voxels along an edge: 64 take an hour on a software driver, 128 several.
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(16..))]
    pub max_resolution: u32,
    /// Setting of global illumination to measure, by its name in the report, and nothing else of that study; may be
    /// repeated.
    #[arg(long, value_name = "NAME")]
    pub setting: Vec<String>,
    /// Scene of global illumination to measure, and nothing else of that study; may be repeated.
    #[arg(long, value_name = "SCENE", value_parser = PossibleValuesParser::new(GI_SCENES))]
    pub scene: Vec<String>,
    /// Folder of the reports, made where it is missing.
    #[arg(long, value_name = "DIR", default_value = "target/tradeoff")]
    pub out: PathBuf,
    /// Measures nothing: reads the reports of an earlier run from this folder.
    #[arg(long, value_name = "DIR")]
    pub from: Option<PathBuf>,
    /// Document in which to renew the tables of advice, between `<!-- tradeoff PLUGIN -->` and
    /// `<!-- end -->`.
    #[arg(long, value_name = "FILE")]
    pub advise: Option<PathBuf>,
}

impl Options {
    /// The studies that were asked for.
    pub fn studies(&self) -> impl Iterator<Item = &'static Study> {
        STUDIES
            .iter()
            .filter(|study| self.plugin == ALL || self.plugin == study.name)
    }

    /// How much the studies measure.
    pub fn plan(&self) -> Plan {
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
    STUDIES.iter().map(|study| study.name).chain([ALL])
}

//! The time of the demos' pictures with each setting of a plugin, beside Bevy's own: `tradeoff demo`.
//!
//! What is measured is what a visitor of the examples sees. Each setting is an app, and their frames are interleaved.

use std::path::PathBuf;

use bevy_frugal_lab::{
    runner::{
        self, Scene, Side, Size,
        pictures::{headless_app, show},
    },
    scenes::{ewa::Ewa, wavelet_tex::WaveletTex},
};
use clap::Parser;

use crate::{
    benchmark::time_rows,
    page::{self, machine, number, plugin_page, renew_file},
    record::{PluginTimes, Report, ReportAdapter, TimeRow},
    run::TradeoffError,
};

/// Name of the file in its folder.
pub const FILE: &str = "demo.json";

/// The command line.
#[derive(Clone, Debug, Parser)]
pub struct Options {
    /// Only this plugin.
    #[arg(long, value_name = "PLUGIN")]
    plugin: Option<String>,
    /// Folder of the figures, made where it is missing.
    #[arg(long, value_name = "DIR", default_value = "target/tradeoff")]
    out: PathBuf,
    /// Size of the pictures in pixels.
    #[arg(long, value_name = "WxH", default_value = "640x360")]
    size: Size,
    /// Rounds of the interleaved benchmark.
    #[arg(long, value_name = "N", default_value_t = 7)]
    rounds: u32,
    /// Frames of a setting in a round.
    #[arg(long, value_name = "N", default_value_t = 3)]
    frames: u32,
    /// Measures nothing: renews the tables in the plugins' pages from the figures in the folder.
    #[arg(long)]
    advise: bool,
}

/// A demo with what all its candidates have set, and the candidates: a name, a side and settings. The first is Bevy's
/// own.
struct Demo {
    plugin: &'static str,
    scene: &'static dyn Scene,
    set: &'static [&'static str],
    candidates: &'static [(&'static str, Side, &'static str)],
}

static DEMOS: [Demo; 2] = [
    Demo {
        plugin: "ewa",
        scene: &Ewa,
        set: &["place=floor", "motion=false"],
        candidates: &[
            ("Bevy's own, trilinear", Side::After, "after=hardware"),
            ("`Anisotropic`", Side::After, "after=anisotropic"),
            ("`SoftwareAnisotropic`", Side::After, "after=software_af16"),
            ("`Stochastic`", Side::After, "after=stochastic"),
            ("`Approximate`", Side::After, "after=approximate"),
            ("`Bilinear`", Side::After, "after=bilinear"),
            ("`Linear` (default)", Side::After, "after=linear"),
            ("`Reference`", Side::After, "after=reference"),
        ],
    },
    Demo {
        plugin: "wavelet_tex",
        scene: &WaveletTex,
        set: &["place=room"],
        candidates: &[
            ("RGBA8, trilinear", Side::Before, "filter=trilinear"),
            ("`Nearest`", Side::After, "filter=nearest"),
            (
                "`NearestMipLinear`",
                Side::After,
                "filter=nearest_mip_linear",
            ),
            ("`Stochastic`", Side::After, "filter=stochastic"),
            ("`StochasticQuad`", Side::After, "filter=stochastic_quad"),
            ("`Bilinear`", Side::After, "filter=bilinear"),
            ("`Trilinear` (default)", Side::After, "filter=trilinear"),
            ("`Anisotropic`", Side::After, "filter=anisotropic"),
        ],
    },
];

/// Measures, or renews the pages.
pub fn run(options: &Options) -> Result<(), TradeoffError> {
    if options.advise {
        let report = Report::read(options.out.join(FILE))?;
        for (page, name, table) in pages(&report) {
            renew_file(&page, &name, &table)?;
        }
        return Ok(());
    }
    let mut report = Report::<PluginTimes>::default().of_today();
    report.rows.size = options.size.to_string();
    let is_selected = |demo: &&Demo| options.plugin.as_deref().is_none_or(|p| p == demo.plugin);
    for demo in DEMOS.iter().filter(is_selected) {
        let (adapter, rows) = demo.rows(options)?;
        report.adapter = adapter;
        report.rows.plugins.insert(demo.plugin.into(), rows);
        println!("{}", table(&report, demo.plugin));
    }
    Ok(report.write(options.out.join(FILE))?)
}

impl Demo {
    fn rows(&self, options: &Options) -> Result<(ReportAdapter, Vec<TimeRow>), TradeoffError> {
        let mut candidates = Vec::new();
        for (name, side, setting) in self.candidates {
            let Size { width, height } = options.size;
            let set = [self.set, &[*setting]].concat();
            let picture = runner::Options::picture(width, height, &set);
            let mut app = headless_app(self.scene, &picture)?;
            show(&mut app, *side)?;
            candidates.push((app, TimeRow::new(self.scene.name(), *name)));
        }
        Ok(time_rows(candidates, options.rounds, options.frames, None)?)
    }
}

/// The table of a plugin's page: milliseconds of a frame on the GPU, and its ratio to the first row's.
fn table(report: &Report<PluginTimes>, plugin: &str) -> String {
    let rows = report.rows.plugins.get(plugin).into_iter().flatten();
    let rows: Vec<_> = rows
        .filter_map(|row| Some((row, row.times.gpu_ms?)))
        .collect();
    let Some(&(_, baseline)) = rows.first() else {
        return String::new();
    };
    let rows = rows.iter().map(|(row, ms)| {
        let factor = number(Some(ms / baseline), 2);
        vec![row.setting.clone(), number(Some(*ms), 1), factor]
    });
    let table = page::table(&["filter", "frame, ms", "of Bevy's"], rows);
    format!(
        "Measured on {}, {}.\n\n{table}",
        machine(report),
        report.rows.size
    )
}

/// The pages with their tables, by the names of the marks around them.
pub fn pages(report: &Report<PluginTimes>) -> impl Iterator<Item = (PathBuf, String, String)> {
    DEMOS.iter().map(|demo| {
        let plugin = demo.plugin;
        let name = format!("{plugin} demo");
        (plugin_page(plugin), name, table(report, plugin))
    })
}

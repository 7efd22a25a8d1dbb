//! The times of all plugins on the GPU that is there, by its own time stamps, in a few minutes: `tradeoff gpu`.
//!
//! It is what the thesis measured: the share of a texture unit's speed (its figure 3.25 and table 5.1), fill rate and
//! resolve (table 4.1), and the passes of global illumination (tables 6.1 and 6.2). Accuracy depends on no GPU, and is
//! in the studies. Each part is written as soon as it is measured.

use std::{
    collections::BTreeMap,
    fmt::Write,
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

use bevy::utils::default;
use bevy_frugal_lab::{content, lookups::scenes::SCENES, runner::Size};
use bevy_voxel_gi::{Bounces, Receiver, Solver, VoxelGiSettings, VoxelLight};
use clap::Parser;
use indicatif::ProgressBar;

use crate::{
    benchmark::time_rows,
    ewa,
    page::{machine, number, plugin_page, renew_file, table},
    plan::Plan,
    record::{PluginTimes, Report, ReportAdapter, TimeRow, Times},
    run::TradeoffError,
    voxel_gi::{load, settings::SPANS},
    wavelet_tex::tunnel::{self, FILTERS},
    ycocg_fb::cost::{self, Load, all_cameras},
};

const FILE: &str = "gpu.json";

/// Measures, or renews the pages.
pub fn run(options: &Options) -> Result<(), TradeoffError> {
    match &options.advise {
        Some(file) => renew(file),
        None => measure(options),
    }
}

/// Measures part after part. One that fails does not keep the others from being measured; the last error is returned.
fn measure(options: &Options) -> Result<(), TradeoffError> {
    let start = Instant::now();
    let limit = Duration::from_secs_f64(60.0 * options.minutes.max(0.0));
    let mut report = Report::<PluginTimes>::default().of_today();
    report.rows.size = options.size.to_string();
    let progress = ProgressBar::hidden();
    let mut failure = None;
    let plan = Plan {
        rounds: options.rounds,
        frames: options.frames,
        tunnel_frames: options.frames,
        ..Plan::new(true)
    };
    for (name, part) in PARTS {
        for step in (part.steps)(options) {
            if start.elapsed() > limit {
                eprintln!("{name}: left out, {} minutes are over", options.minutes);
                continue;
            }
            match (part.rows)(options, step, &plan, &progress) {
                Ok((adapter, rows)) => {
                    report.adapter = adapter;
                    let plugins = &mut report.rows.plugins;
                    plugins.entry(part.plugin.into()).or_default().extend(rows);
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
fn write(report: &Report<PluginTimes>, out: &Path) -> Result<PathBuf, TradeoffError> {
    let folder = out.join(folder_name(&report.adapter.name));
    std::fs::create_dir_all(&folder).map_err(TradeoffError::file(&folder))?;
    report.write(folder.join(FILE))?;
    let text = format!(
        "# Times on a GPU\n\n{}\n\n{}",
        measured_on(report),
        all(&report.rows)
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

/// The command line of `tradeoff gpu`.
#[derive(Clone, Debug, Parser)]
pub struct Options {
    /// Folder in which the adapter gets a folder of its own.
    #[arg(long, value_name = "DIR", default_value = "target/tradeoff")]
    pub out: PathBuf,
    /// Size of the pictures in pixels.
    #[arg(long, value_name = "WxH", default_value = "1920x1080")]
    pub size: Size,
    /// Coinciding layers of the fill rate: more where a GPU is fast.
    #[arg(long, value_name = "N", default_value_t = 32)]
    pub layers: usize,
    /// Voxels along an edge of the volumes of light.
    #[arg(long, value_name = "N,..", value_delimiter = ',', default_values_t = [32, 64, 128],
        value_parser = clap::value_parser!(u32).range(8..=128))]
    pub resolutions: Vec<u32>,
    /// Rounds of each interleaved benchmark.
    #[arg(long, value_name = "N", default_value_t = 5)]
    pub rounds: u32,
    /// Frames of a setting in a round.
    #[arg(long, value_name = "N", default_value_t = 15)]
    pub frames: u32,
    /// Begins nothing new after this time.
    #[arg(long, value_name = "N", default_value_t = 8.0)]
    pub minutes: f64,
    /// Measures nothing: renews the tables in the plugins' pages from this file.
    #[arg(long, value_name = "FILE")]
    pub advise: Option<PathBuf>,
}

fn size(options: &Options) -> [u32; 2] {
    [options.size.width, options.size.height]
}

/// Scenes of the lookups: small ellipses, and long ones.
const LOOKUP_SCENES: [&str; 2] = ["tunnel", "checker_5deg"];
const SEED: u64 = 5;

/// A part of the study. Each of its steps is measured by itself.
struct Part {
    /// The plugin of its rows.
    plugin: &'static str,
    steps: fn(&Options) -> Vec<u32>,
    rows: fn(&Options, u32, &Plan, &ProgressBar) -> Rows,
}

type Rows = Result<(ReportAdapter, Vec<TimeRow>), TradeoffError>;

/// All parts, the quickest first.
const PARTS: [(&str, Part); 4] = [
    (
        "filters of wavelet textures",
        Part {
            plugin: "wavelet_tex",
            steps: |_| vec![0],
            rows: |options, _, plan, progress| {
                let picture = content::bricks(plan.tile[0], plan.tile[1], SEED).color;
                let (adapter, rows) =
                    tunnel::rows(&picture, &tunnel::FILTERS, size(options), plan, progress)?;
                let rows = rows.into_iter().map(|row| TimeRow {
                    bytes: Some(row.bytes),
                    times: row.times,
                    ..TimeRow::new("tunnel", row.setting)
                });
                Ok((adapter, rows.collect()))
            },
        },
    ),
    (
        "elliptical filters",
        Part {
            plugin: "ewa",
            steps: |_| (0..LOOKUP_SCENES.len() as u32).collect(),
            rows: |options, step, plan, progress| {
                let name = LOOKUP_SCENES[step as usize];
                let scene = SCENES.iter().find(|scene| scene.name == name);
                let scene = scene.unwrap_or(&SCENES[0]);
                // A square of as many pixels.
                let [width, height] = size(options).map(f64::from);
                let size = (width * height).sqrt().round() as u32;
                ewa::time_rows(scene, size, plan, progress)
            },
        },
    ),
    (
        "fill rate",
        Part {
            plugin: "ycocg_fb",
            steps: |_| (0..cost::STEPS as u32).collect(),
            rows: |options, step, plan, _| {
                let load = cost::loads(options.layers)[step as usize];
                cost::load_rows(load, &all_cameras(), size(options), plan)
            },
        },
    ),
    (
        "global illumination",
        Part {
            plugin: "voxel_gi",
            steps: |options| options.resolutions.clone(),
            rows: |options, resolution, plan, _| light_rows(resolution, size(options), plan),
        },
    ),
];

/// The setting of the row without a volume.
const WITHOUT: &str = "no volume";
/// About as many triangles as a furnished room has.
const TRIANGLES: u32 = 100_000;

/// The rows of a resolution, interleaved.
fn light_rows(resolution: u32, size: [u32; 2], plan: &Plan) -> Rows {
    let mut candidates = Vec::new();
    for (name, volume) in settings(resolution) {
        let (app, row) = load::app(TRIANGLES, volume, size)?;
        let row = TimeRow {
            scene: format!("{resolution}^3"),
            setting: name.into(),
            ..row
        };
        candidates.push((app, row));
    }
    Ok(time_rows(
        candidates,
        plan.rounds,
        plan.frames,
        Some(SPANS),
    )?)
}

fn settings(resolution: u32) -> [(&'static str, Option<VoxelGiSettings>); 5] {
    let with = |light, receiver| {
        Some(VoxelGiSettings {
            resolution,
            light,
            receiver,
            ..default()
        })
    };
    let bounced = |solver| VoxelLight::GlobalIllumination {
        solver,
        bounces: Bounces::default(),
    };
    let occlusion = VoxelLight::AmbientOcclusion {
        radius: 1.0,
        rays: 16,
    };
    let propagate = bounced(Solver::Propagate { iterations: 96 });
    [
        (WITHOUT, None),
        ("trace", with(default(), default())),
        ("trace per pixel", with(default(), Receiver::PerPixel)),
        ("propagate", with(propagate, default())),
        ("ambient_occlusion", with(occlusion, default())),
    ]
}

/// What the tables of the plugins are made by.
const TABLES: [(&str, fn(&Data) -> String); 4] = [
    ("wavelet_tex", wavelet_tex),
    ("ycocg_fb", ycocg_fb),
    ("ewa", ewa),
    ("voxel_gi", voxel_gi),
];

/// Times of frames on the GPU in milliseconds, by scene and setting.
struct Data<'a>(BTreeMap<(&'a str, &'a str), &'a Times>);

impl<'a> Data<'a> {
    fn new(rows: &'a PluginTimes, plugin: &str) -> Self {
        let own = rows.plugins.get(plugin).into_iter().flatten();
        Self(
            own.map(|row| ((&*row.scene, &*row.setting), &row.times))
                .collect(),
        )
    }

    fn ms(&self, scene: &str, setting: &str) -> Option<f64> {
        self.0.get(&(scene, setting))?.gpu_ms
    }

    fn settings(&self, scene: &str) -> impl Iterator<Item = &'a str> {
        let rows = self.0.keys().filter(move |(s, _)| *s == scene);
        rows.map(|(_, setting)| *setting)
    }
}

/// The adapter, the day and the size of the pictures.
fn measured_on(report: &Report<PluginTimes>) -> String {
    format!("Measured on {}, {}.", machine(report), report.rows.size)
}

/// The tables of all plugins.
fn all(rows: &PluginTimes) -> String {
    let mut text = String::new();
    for (plugin, table) in TABLES {
        let _ = writeln!(
            text,
            "## bevy_{plugin}\n\n{}",
            table(&Data::new(rows, plugin))
        );
    }
    text
}

/// Renews the tables between `<!-- tradeoff PLUGIN gpu -->` and `<!-- end -->` in the plugins' pages.
fn renew(file: &Path) -> Result<(), TradeoffError> {
    let report = Report::<PluginTimes>::read(file)?;
    for (plugin, table) in TABLES {
        let table = table(&Data::new(&report.rows, plugin));
        let text = format!("{}\n\n{table}", measured_on(&report));
        renew_file(&plugin_page(plugin), &format!("{plugin} gpu"), &text)?;
    }
    Ok(())
}

/// Each filter: its frame, and its sampling beside that of the texture unit from BC7, which is a frame's time less that
/// of one without a texture.
fn wavelet_tex(data: &Data) -> String {
    let empty = data.ms("tunnel", "no texture");
    let rows = FILTERS.iter().map(|filter| {
        let ours = data.ms("tunnel", &format!("color3 {}", filter.name));
        let hardware = data.ms("tunnel", &format!("bc7 {}", filter.hardware));
        let sampling = |ms: Option<f64>| Some(ms? - empty?).filter(|ms| *ms > 0.0);
        let share = sampling(hardware).and_then(|ms| Some(100.0 * ms / sampling(ours)?));
        vec![
            filter.name.into(),
            number(ours, 3),
            number(hardware, 3),
            number(share, 1),
        ]
    });
    let share = "sampling, % of the texture unit's speed";
    table(&["filter", "frame, ms", "BC7's, ms", share], rows)
}

/// Each method: its frame, and the speed of the texture unit's 16x anisotropic filter that it reaches.
fn ewa(data: &Data) -> String {
    let rows = data.settings(LOOKUP_SCENES[0]).map(|setting| {
        let cells = LOOKUP_SCENES.map(|scene| {
            let ms = data.ms(scene, setting);
            let hardware = data.ms(scene, "hardware_af16");
            let share = hardware.and_then(|hardware| Some(100.0 * hardware / ms?));
            [number(ms, 3), number(share, 1)]
        });
        [vec![format!("`{setting}`")], cells.concat()].concat()
    });
    let share = "% of the texture unit's speed";
    table(
        &["method", "tunnel, ms", share, "checker 5 deg, ms", share],
        rows,
    )
}

/// Each camera: an empty frame, and a layer of opaque and blended fragments.
fn ycocg_fb(data: &Data) -> String {
    let layers = { data.0.keys() }.filter_map(|(scene, _)| scene.split('_').nth(1)?.parse().ok());
    let [empty, opaque, blended, empty_4x, opaque_4x] = cost::loads(layers.max().unwrap_or(0));
    let rows = all_cameras().into_iter().map(|camera| {
        let ms = |load: Load| data.ms(&load.name(), camera.name);
        let layer = |load: Load, empty: Load| Some((ms(load)? - ms(empty)?) / load.layers as f64);
        vec![
            format!("`{}`", camera.name),
            camera.bytes.to_string(),
            number(ms(empty), 3),
            number(layer(opaque, empty), 4),
            number(layer(blended, empty), 4),
            number(ms(empty_4x), 3),
            number(layer(opaque_4x, empty_4x), 4),
        ]
    });
    let heads = [
        "camera",
        "bytes a sample",
        "empty frame, ms",
        "opaque layer, ms",
        "blended layer, ms",
        "empty frame 4x, ms",
        "opaque layer 4x, ms",
    ];
    table(&heads, rows)
}

/// Each setting: its passes, and what is left of the frame beyond one without a volume, which pixels pay to read it.
fn voxel_gi(data: &Data) -> String {
    let mut rows: Vec<_> = { data.0.iter() }
        .filter(|((_, setting), _)| *setting != WITHOUT)
        .collect();
    let voxels = |scene: &str| scene.split('^').next().and_then(|r| r.parse::<u32>().ok());
    rows.sort_by_key(|((scene, setting), _)| (voxels(scene), *setting));
    let rows = rows.into_iter().map(|((scene, setting), times)| {
        let sum: f64 = times.stage_ms.values().sum();
        let without = data.ms(scene, WITHOUT);
        let receive = without.and_then(|without| Some(times.gpu_ms? - sum - without));
        let passes: Vec<_> = { times.stage_ms.iter() }
            .map(|(name, ms)| format!("{name} {ms:.3}"))
            .collect();
        vec![
            (*scene).into(),
            format!("`{setting}`"),
            format!("{sum:.3}: {}", passes.join(", ")),
            number(receive, 3),
        ]
    });
    table(&["volume", "setting", "passes, ms", "receive, ms"], rows)
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
    #[test]
    fn a_size_has_two_sides() {
        let (width, height) = (160, 90);
        assert_eq!("160x90".parse(), Ok(Size { width, height }));
        assert!("160".parse::<Size>().is_err() && "0x4".parse::<Size>().is_err());
    }

    #[test]
    fn shares_and_layers_are_beside_what_they_are_of() {
        let row = |(scene, setting, ms): (&str, &str, f64)| {
            TimeRow::new(scene, setting).with_times(Times {
                gpu_ms: Some(ms),
                stage_ms: [("gather".to_string(), 0.5)].into(),
                ..Times::default()
            })
        };
        let plugin = |name: &str, rows: &[(&str, &str, f64)]| {
            (name.to_string(), rows.iter().copied().map(row).collect())
        };
        let rows = PluginTimes {
            size: String::new(),
            plugins: [
                plugin(
                    "ewa",
                    &[("tunnel", "linear", 4.0), ("tunnel", "hardware_af16", 1.0)],
                ),
                plugin(
                    "wavelet_tex",
                    &[
                        ("tunnel", "no texture", 1.0),
                        ("tunnel", "bc7 nearest", 1.5),
                        ("tunnel", "color3 nearest", 3.0),
                    ],
                ),
                plugin(
                    "ycocg_fb",
                    &[
                        ("overdraw_0_opaque_1x", "packed_hdr", 1.0),
                        ("overdraw_32_blend_1x", "packed_hdr", 4.2),
                    ],
                ),
                plugin(
                    "voxel_gi",
                    &[("32^3", WITHOUT, 1.0), ("32^3", "trace", 1.75)],
                ),
            ]
            .into(),
        };
        let text = all(&rows);
        for line in [
            "| `linear` | 4.000 | 25.0 |  |  |",
            "| nearest | 3.000 | 1.500 | 25.0 |",
            "| `packed_hdr` | 4 | 1.000 |  | 0.1000 |  |  |",
            "| 32^3 | `trace` | 0.500: gather 0.500 | 0.250 |",
        ] {
            assert!(text.lines().any(|found| found == line), "{line}\n{text}");
        }
    }
}

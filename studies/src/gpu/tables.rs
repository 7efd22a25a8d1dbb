//! The times as tables, one for each plugin's page.

use std::{collections::BTreeMap, fmt::Write, path::Path};

use super::{gi, parts::LOOKUP_SCENES};
use crate::{
    markdown::{machine, plugin_page, renew_file},
    record::{Measurement, Report},
    study::TradeoffError,
    wavelet_tex::tunnel::FILTERS,
    ycocg_fb::{
        cameras::all_cameras,
        cost::{self, Load},
    },
};

/// What the tables of the plugins are made by.
const TABLES: [(&str, fn(&Data) -> String); 4] = [
    ("wavelet_tex", wavelet_tex),
    ("ycocg_fb", ycocg_fb),
    ("ewa", ewa),
    ("voxel_gi", voxel_gi),
];

/// Times of frames on the GPU in milliseconds, by scene and setting.
struct Data<'a>(BTreeMap<(&'a str, &'a str), &'a Measurement>);

impl<'a> Data<'a> {
    fn new(report: &'a Report, plugin: &str) -> Self {
        let own = report
            .measurements
            .iter()
            .filter(|row| row.plugin == plugin);
        Self(own.map(|row| ((&*row.scene, &*row.setting), row)).collect())
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
pub fn measured_on(report: &Report) -> String {
    let size =
        { report.measurements.first() }.map_or(String::new(), |row| format!(", {}", row.reference));
    format!("Measured on {}{size}.", machine(report))
}

/// The tables of all plugins.
pub fn all(report: &Report) -> String {
    let mut text = String::new();
    for (plugin, table) in TABLES {
        let _ = writeln!(
            text,
            "## bevy_{plugin}\n\n{}",
            table(&Data::new(report, plugin))
        );
    }
    text
}

/// Renews the tables between `<!-- tradeoff PLUGIN gpu -->` and `<!-- end -->` in the plugins' pages.
///
/// # Errors
/// [`TradeoffError`] where a file cannot be read or written.
pub fn renew(file: &Path) -> Result<(), TradeoffError> {
    let report = Report::read(file)?;
    for (plugin, table) in TABLES {
        let table = table(&Data::new(&report, plugin));
        let text = format!("{}\n\n{table}", measured_on(&report));
        renew_file(&plugin_page(plugin), &format!("{plugin} gpu"), &text)?;
    }
    Ok(())
}

fn number(value: Option<f64>, decimals: usize) -> String {
    value.map_or(String::new(), |value| format!("{value:.decimals$}"))
}

/// Each filter: its frame, and its sampling beside that of the texture unit from BC7, which is a frame's time less that
/// of one without a texture.
fn wavelet_tex(data: &Data) -> String {
    let mut text = "| filter | frame, ms | BC7's, ms | sampling, % of the texture unit's speed |\n\
                    | --- | --- | --- | --- |\n"
        .to_string();
    let empty = data.ms("tunnel", "no texture");
    for filter in FILTERS {
        let ours = data.ms("tunnel", &format!("color3 {}", filter.name));
        let hardware = data.ms("tunnel", &format!("bc7 {}", filter.hardware));
        let sampling = |ms: Option<f64>| Some(ms? - empty?);
        let share = match (sampling(hardware), sampling(ours)) {
            (Some(hardware), Some(ours)) if hardware > 0.0 && ours > 0.0 => {
                Some(100.0 * hardware / ours)
            }
            _ => None,
        };
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} |",
            filter.name,
            number(ours, 3),
            number(hardware, 3),
            number(share, 1)
        );
    }
    text
}

/// Each method: its frame, and the speed of the texture unit's 16x anisotropic filter that it reaches.
fn ewa(data: &Data) -> String {
    let mut text = "| method | tunnel, ms | % of the texture unit's speed | checker 5 deg, ms | \
                    % of the texture unit's speed |\n| --- | --- | --- | --- | --- |\n"
        .to_string();
    for setting in data.settings(LOOKUP_SCENES[0]) {
        let cells = LOOKUP_SCENES.map(|scene| {
            let ms = data.ms(scene, setting);
            let hardware = data.ms(scene, "hardware_af16");
            let share = hardware.and_then(|hardware| Some(100.0 * hardware / ms?));
            format!("{} | {}", number(ms, 3), number(share, 1))
        });
        let _ = writeln!(text, "| `{setting}` | {} |", cells.join(" | "));
    }
    text
}

/// Each camera: an empty frame, and a layer of opaque and blended fragments.
fn ycocg_fb(data: &Data) -> String {
    let mut text =
        "| camera | bytes a sample | empty frame, ms | opaque layer, ms | blended layer, ms | \
                    empty frame 4x, ms | opaque layer 4x, ms |\n\
                    | --- | --- | --- | --- | --- | --- | --- |\n"
            .to_string();
    let layers = data
        .0
        .keys()
        .filter_map(|(scene, _)| scene.split('_').nth(1)?.parse().ok());
    let [empty, opaque, blended, empty_4x, opaque_4x] = cost::loads(layers.max().unwrap_or(0));
    for camera in all_cameras() {
        let ms = |load: Load| data.ms(&load.name(), camera.name);
        let layer = |load: Load, empty: Load| Some((ms(load)? - ms(empty)?) / load.layers as f64);
        let _ = writeln!(
            text,
            "| `{}` | {} | {} | {} | {} | {} | {} |",
            camera.name,
            camera.bytes,
            number(ms(empty), 3),
            number(layer(opaque, empty), 4),
            number(layer(blended, empty), 4),
            number(ms(empty_4x), 3),
            number(layer(opaque_4x, empty_4x), 4),
        );
    }
    text
}

/// Each setting: its passes, and what is left of the frame beyond one without a volume, which pixels pay to read it.
fn voxel_gi(data: &Data) -> String {
    let mut text =
        "| volume | setting | passes, ms | receive, ms |\n| --- | --- | --- | --- |\n".to_string();
    let mut rows: Vec<_> = data
        .0
        .iter()
        .filter(|((_, setting), _)| *setting != gi::WITHOUT)
        .collect();
    let voxels = |scene: &str| scene.split('^').next().and_then(|r| r.parse::<u32>().ok());
    rows.sort_by_key(|((scene, setting), _)| (voxels(scene), *setting));
    for ((scene, setting), row) in rows {
        let sum: f64 = row.stage_ms.values().sum();
        let without = data.ms(scene, gi::WITHOUT);
        let receive = without.and_then(|without| Some(row.gpu_ms? - sum - without));
        let passes: Vec<_> = { row.stage_ms.iter() }
            .map(|(name, ms)| format!("{name} {ms:.3}"))
            .collect();
        let _ = writeln!(
            text,
            "| {scene} | `{setting}` | {sum:.3}: {} | {} |",
            passes.join(", "),
            number(receive, 3)
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_and_layers_are_beside_what_they_are_of() {
        let row = |plugin: &str, scene: &str, setting: &str, ms| Measurement {
            plugin: plugin.into(),
            scene: scene.into(),
            setting: setting.into(),
            gpu_ms: Some(ms),
            stage_ms: [("gather".to_string(), 0.5)].into(),
            ..Measurement::default()
        };
        let report = Report {
            measurements: vec![
                row("ewa", "tunnel", "linear", 4.0),
                row("ewa", "tunnel", "hardware_af16", 1.0),
                row("wavelet_tex", "tunnel", "no texture", 1.0),
                row("wavelet_tex", "tunnel", "bc7 nearest", 1.5),
                row("wavelet_tex", "tunnel", "color3 nearest", 3.0),
                row("ycocg_fb", "overdraw_0_opaque_1x", "packed_hdr", 1.0),
                row("ycocg_fb", "overdraw_32_blend_1x", "packed_hdr", 4.2),
                row("voxel_gi", "32^3", gi::WITHOUT, 1.0),
                row("voxel_gi", "32^3", "trace", 1.75),
            ],
            ..Report::default()
        };
        let text = all(&report);
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

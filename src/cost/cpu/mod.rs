//! The CPU's time for a frame with many meshes, where the GPU takes none: what is in it is Bevy and the plugin.
//!
//! Bevy alone and each plugin run in processes of their own, one after the other and in several rounds, so that what
//! slows the machine down for a while slows down all of them. Other programs add to the time on the clock, but
//! hardly to the process's own time on the processor, which is why there are both.

mod field;
mod process_time;
pub mod record;
pub mod systems;
pub mod tables;

use std::{collections::BTreeMap, path::Path, time::Instant};

use serde::{Deserialize, Serialize};

use self::{
    field::Field,
    process_time::process_ms,
    record::{CpuRow, FILE},
};
use super::{
    configurations::{Kind, PLUGINS, configurations},
    error::CostError,
    pipelines::settle,
    record::write_json,
    shim,
};
use crate::headless::median;

/// The name of Bevy alone, with which every plugin is compared.
const BEVY: &str = "bevy";
const ROUNDS: usize = 3;
/// Blocks of frames in a process, and frames in each.
const BLOCKS: usize = 3;
const FRAMES: usize = 8;
/// Frames after which a volume of light has settled where nothing moves.
const FIRST_FRAMES: usize = 60;

/// The times that a process measures.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Sample {
    frame_ms: f64,
    shortest_ms: f64,
    process_ms: f64,
}

/// Writes `cpu.json` into a folder; or, under the driver, measures one process's part.
///
/// # Errors
/// [`CostError`].
pub fn measure(
    inside: bool,
    gpu: &str,
    plugin: Option<&str>,
    folder: &Path,
) -> Result<(), CostError> {
    if inside {
        let (plugin, field) = Field::of_part(&shim::part())?;
        println!("{}", serde_json::json!(sampled(&plugin, field)?));
        return Ok(());
    }
    let plugins = PLUGINS.iter().map(|(name, _)| *name);
    let plugins: Vec<_> = [BEVY].into_iter().chain(plugins).collect();
    let plugins: Vec<_> = { plugins.into_iter() }
        .filter(|name| *name == BEVY || plugin.is_none_or(|wanted| wanted == *name))
        .collect();
    let mut parts = Vec::new();
    for _ in 0..ROUNDS {
        for field in Field::all() {
            parts.extend(plugins.iter().map(|plugin| field.part(plugin)));
        }
    }
    let mut program = shim::this_program();
    program.args(["cost", "--cpu", "--inside"]);
    let mut samples: BTreeMap<String, Vec<Sample>> = BTreeMap::new();
    for (part, output) in parts
        .iter()
        .zip(shim::run(gpu, &program, parts.iter().cloned())?)
    {
        let output = output?.stdout;
        let mut lines = output.split(|byte| *byte == b'\n');
        let sample: Sample = lines
            .find_map(|line| serde_json::from_slice(line).ok())
            .ok_or_else(|| CostError::Failed(format!("{part}: no times")))?;
        println!(
            "{part}: {:.2} ms, {:.2} ms of processors",
            sample.frame_ms, sample.process_ms
        );
        samples.entry(part.clone()).or_default().push(sample);
    }
    let mut rows = Vec::new();
    for field in Field::all() {
        let bevys = &samples[&field.part(BEVY)];
        for plugin in plugins.iter().filter(|plugin| **plugin != BEVY) {
            rows.push(row(plugin, field, &samples[&field.part(plugin)], bevys));
        }
    }
    write_json(&rows, &folder.join(FILE))
}

fn row(plugin: &str, field: Field, samples: &[Sample], bevys: &[Sample]) -> CpuRow {
    let medians = |value: fn(&Sample) -> f64, samples: &[Sample]| {
        let values: Vec<_> = samples.iter().map(value).collect();
        median(&values).unwrap_or_default()
    };
    let beside = |value: fn(&Sample) -> f64| {
        let differences: Vec<_> = { samples.iter().zip(bevys) }
            .map(|(sample, bevy)| value(sample) - value(bevy))
            .collect();
        let rounded = |ms: f64| (ms * 100.0).round() / 100.0;
        let range = { differences.iter() }
            .fold([f64::MAX, f64::MIN], |[a, b], ms| [a.min(*ms), b.max(*ms)]);
        [
            rounded(median(&differences).unwrap_or_default()),
            rounded(medians(value, bevys)),
            rounded(0.5 * (range[1] - range[0])),
        ]
    };
    let [frame_ms, baseline_ms, _] = beside(|sample| sample.frame_ms);
    let [shortest_ms, baseline_shortest_ms, _] = beside(|sample| sample.shortest_ms);
    let [process_ms, baseline_process_ms, noise_ms] = beside(|sample| sample.process_ms);
    CpuRow {
        plugin: plugin.into(),
        meshes: field.meshes,
        materials: field.materials,
        moving: field.moving,
        replaced: field.replaced,
        frame_ms,
        baseline_ms,
        shortest_ms,
        baseline_shortest_ms,
        process_ms,
        baseline_process_ms,
        noise_ms,
    }
}

/// The plugin at its defaults, or none.
fn kind(plugin: &str) -> Kind {
    let is_default = |setting: &str| PLUGINS.contains(&(plugin, setting));
    let mut all = configurations().into_iter();
    all.find(|c| c.plugin == plugin && is_default(&c.setting))
        .map_or(Kind::Bevy, |c| c.kind)
}

fn sampled(plugin: &str, field: Field) -> Result<Sample, CostError> {
    let mut app = field::app(field, &kind(plugin))?;
    settle(&mut app)?;
    if field.moving + field.replaced == 0 {
        (0..FIRST_FRAMES).for_each(|_| app.app_mut().update());
    }
    let (mut times, mut process_times) = (Vec::new(), Vec::new());
    systems::begin();
    for _ in 0..BLOCKS {
        let before = process_ms();
        for _ in 0..FRAMES {
            let start = Instant::now();
            app.app_mut().update();
            times.push(start.elapsed().as_secs_f64() * 1e3);
        }
        process_times.push((process_ms() - before) / FRAMES as f64);
    }
    systems::end(BLOCKS * FRAMES);
    Ok(Sample {
        frame_ms: median(&times).unwrap_or_default(),
        shortest_ms: times.into_iter().fold(f64::MAX, f64::min),
        process_ms: median(&process_times).unwrap_or_default(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_is_what_a_plugin_adds_in_the_same_round() {
        let sample = |ms| Sample {
            frame_ms: ms,
            shortest_ms: 0.5 * ms,
            process_ms: 2.0 * ms,
        };
        let bevys = [10.0, 30.0, 11.0].map(sample);
        let samples = [11.0, 32.0, 12.5].map(sample);
        let field = Field {
            meshes: 1000,
            materials: 1,
            moving: 10,
            replaced: 0,
        };
        let row = row("ewa", field, &samples, &bevys);
        assert_eq!((row.frame_ms, row.baseline_ms), (1.5, 11.0));
        assert_eq!((row.process_ms, row.noise_ms), (3.0, 1.0));
    }
}

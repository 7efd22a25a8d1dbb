//! The plugin's systems by name, from samples that Linux's `perf` takes of where the processors are. Bevy is compiled
//! without its spans here; the names are those of the functions in the program.

use std::{
    collections::BTreeMap,
    fs,
    path::Path,
    process::{Command, Stdio},
};

use serde::{Deserialize, Serialize};

use super::field::Field;
use crate::cost::{configurations::PLUGINS, error::CostError, record, shim};

/// Name of the file in its folder.
pub const FILE: &str = "cpu_systems.json";
/// Samples a second of each processor.
const RATE: u32 = 1999;
/// Systems that take less are not listed.
const LEAST_MS: f64 = 0.1;
/// What the lines begin with that say when measuring begins and ends.
const MARK: &str = "measuring: ";

/// The time of a system.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SystemRow {
    /// Name of the plugin.
    pub plugin: String,
    /// Number of meshes in view.
    pub meshes: usize,
    /// Number of materials among them.
    pub materials: usize,
    /// Number of meshes that move in every frame.
    pub moving: usize,
    /// Number of meshes that are despawned in every frame, and as many spawned.
    pub replaced: usize,
    /// Path of the function, or the name of the crate for all of its systems.
    pub system: String,
    /// Its time on processors in a frame in milliseconds, with all that it calls on its thread.
    pub process_ms: f64,
}

/// Says that frames are measured from here on.
pub fn begin() {
    println!("{MARK}0 {}", seconds_since_boot());
}

/// Says that so many frames have been measured.
pub fn end(frames: usize) {
    println!("{MARK}{frames} {}", seconds_since_boot());
}

/// On `perf`'s clock, in hundredths.
fn seconds_since_boot() -> String {
    let text = fs::read_to_string("/proc/uptime").unwrap_or_default();
    text.split(' ').next().unwrap_or_default().into()
}

/// Writes the systems of each plugin in the larger fields of one material beside the times in the folder, and what
/// all of a plugin's systems take together, by the name of its crate.
///
/// # Errors
/// [`CostError::Failed`] where there is no `perf`, or the program fails under it.
pub fn measure(gpu: &str, folder: &Path) -> Result<(), CostError> {
    let mut rows = Vec::new();
    for field in Field::all().filter(|field| field.meshes >= 10_000 && field.materials == 1) {
        for (plugin, _) in PLUGINS {
            let found = sampled(gpu, plugin, field)?;
            for (system, process_ms) in found {
                println!("{}: {process_ms:.2} ms {system}", field.part(plugin));
                rows.push(SystemRow {
                    plugin: plugin.into(),
                    meshes: field.meshes,
                    materials: field.materials,
                    moving: field.moving,
                    replaced: field.replaced,
                    system,
                    process_ms,
                });
            }
        }
    }
    record::write_json(&rows, &folder.join(FILE))
}

fn sampled(gpu: &str, plugin: &str, field: Field) -> Result<Vec<(String, f64)>, CostError> {
    let name = field.part(plugin);
    let failed = |text: &str| CostError::Failed(format!("{name}: {text}"));
    let file = std::env::temp_dir().join(format!("cost-{}.perf", std::process::id()));
    let rate = RATE.to_string();
    let mut perf = Command::new("perf");
    perf.args([
        "record",
        "-q",
        "-k",
        "CLOCK_BOOTTIME",
        "-e",
        "cpu-clock",
        "-F",
        &rate,
        "--call-graph",
        "dwarf,16384",
        "-o",
    ]);
    perf.arg(&file).arg("--").arg(shim::script().get_program());
    perf.args(["run", gpu])
        .arg(shim::this_program().get_program());
    perf.args(["cost", "--cpu", "--inside"])
        .env(shim::PART, &name);
    let output = perf.stderr(Stdio::null()).output();
    let output = output.map_err(|error| failed(&format!("`perf` is needed for this: {error}")))?;
    let marks = marks(&String::from_utf8_lossy(&output.stdout));
    let script = Command::new("perf")
        .args(["script", "--no-inline", "-F", "time,ip,sym", "-i"])
        .arg(&file)
        .output();
    let _ = fs::remove_file(&file);
    let script = script.map_err(|error| failed(&error.to_string()))?;
    let (frames, window) = marks.ok_or_else(|| failed("no frames"))?;
    let counts = counts(&String::from_utf8_lossy(&script.stdout), window, plugin);
    let sample_ms = 1e3 / f64::from(RATE) / frames;
    let ms = |count: u32| (f64::from(count) * sample_ms * 100.0).round() / 100.0;
    let all = (format!("bevy_{plugin}"), ms(counts.values().sum()));
    let systems = counts
        .into_iter()
        .map(|(system, count)| (system, ms(count)));
    let mut systems: Vec<_> = systems.filter(|(_, ms)| *ms >= LEAST_MS).collect();
    systems.push(all);
    systems.sort_by(|a, b| b.1.total_cmp(&a.1));
    Ok(systems)
}

/// Samples in a window of time by the plugin's system. A sample is a line with its time, and then a line for each
/// function, the innermost first: the system is the outermost one of the plugin.
fn counts(script: &str, window: [f64; 2], plugin: &str) -> BTreeMap<String, u32> {
    let crate_path = format!("bevy_{plugin}::");
    let mut counts = BTreeMap::new();
    for sample in script.split("\n\n") {
        let mut lines = sample.trim().lines();
        let time = lines
            .next()
            .and_then(|line| line.trim().strip_suffix(':')?.parse().ok());
        let is_measured = time.is_some_and(|time: f64| window[0] <= time && time <= window[1]);
        let system = lines.rev().find_map(|line| system(line, &crate_path));
        if let Some(system) = system.filter(|_| is_measured) {
            *counts.entry(system.to_owned()).or_default() += 1;
        }
    }
    counts
}

/// How many frames were measured, from when to when.
fn marks(output: &str) -> Option<(f64, [f64; 2])> {
    let marks = output
        .lines()
        .filter_map(|line| line.strip_prefix(MARK)?.split_once(' '));
    let marks: Vec<[f64; 2]> = marks
        .filter_map(|(frames, time)| Some([frames.parse().ok()?, time.parse().ok()?]))
        .collect();
    match marks[..] {
        [[_, start], [frames, end]] => Some((frames, [start, end])),
        _ => None,
    }
}

/// The last path of the crate in a symbol. The function is the last parameter of what Bevy makes of a system, and of
/// what a system calls with a closure.
fn system<'a>(symbol: &'a str, crate_path: &str) -> Option<&'a str> {
    let path = &symbol[symbol.rfind(crate_path)?..];
    let end = path.find(|c: char| !c.is_alphanumeric() && c != '_' && c != ':');
    Some(path[..end.unwrap_or(path.len())].trim_end_matches(':'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_system_is_the_last_path_of_its_symbol() {
        let symbol = "<bevy_ecs::system::FunctionSystem<fn(Res<bevy_voxel_gi::report::Report>), (), (), \
                      bevy_voxel_gi::extract::meshes::extract_scene> as System>::run_unsafe";
        let name = "bevy_voxel_gi::extract::meshes::extract_scene";
        assert_eq!(system(symbol, "bevy_voxel_gi::"), Some(name));
        assert_eq!(
            system(&format!("{name}::{{closure#0}}"), "bevy_voxel_gi::"),
            Some(name)
        );
        assert_eq!(system(symbol, "bevy_ewa::"), None);
    }

    #[test]
    fn samples_count_for_the_outermost_function_within_the_window() {
        let sample = |time: f64| {
            format!(
                "{time}: \n\t 1 malloc\n\t 2 bevy_ewa::mips::level\n\t 3 bevy_ewa::mips::start\n\t 4 main\n\n"
            )
        };
        let script = [1.0, 2.0, 2.5, 4.0].map(sample).concat();
        let found = counts(&script, [1.5, 3.0], "ewa");
        assert_eq!(found, [("bevy_ewa::mips::start".to_string(), 2)].into());
        assert!(counts(&script, [1.5, 3.0], "voxel_gi").is_empty());
    }

    #[test]
    fn marks_are_read_back() {
        let output = format!("{MARK}0 1.5\n{{}}\n{MARK}30 2.25\n");
        assert_eq!(marks(&output), Some((30.0, [1.5, 2.25])));
        assert_eq!(marks("{}"), None);
    }
}

//! The times of a plugin, in a file.

use serde::{Deserialize, Serialize};

/// Name of the file in its folder.
pub const FILE: &str = "cpu.json";

/// The CPU's time with a plugin at its defaults, less Bevy's own.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CpuRow {
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
    /// Time of a frame in milliseconds, less Bevy's: the median of the rounds' medians.
    pub frame_ms: f64,
    /// Bevy's.
    pub baseline_ms: f64,
    /// The same of the shortest frames.
    pub shortest_ms: f64,
    /// Bevy's.
    pub baseline_shortest_ms: f64,
    /// Time of all threads on processors in a frame in milliseconds, less Bevy's: the median of the rounds.
    pub process_ms: f64,
    /// Bevy's.
    pub baseline_process_ms: f64,
    /// Half of the difference between the rounds' greatest and least `process_ms`.
    pub noise_ms: f64,
}

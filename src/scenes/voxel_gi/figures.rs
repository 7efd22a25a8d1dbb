//! The plugin's report as figures and notes, and whether a picture is worth taking.

use bevy::prelude::*;
use bevy_voxel_gi::{VoxelGiReport, VoxelGiState};

use super::truth::Truth;
use crate::{
    headless::AwaitedWork,
    runner::{MemoryFigures, Notes},
};

/// What a picture waits for, as it is called in messages: the light has settled.
pub const LIGHT: &str = "the light";
/// The same of the path-traced picture and of the comparison with it.
const TRUTH: &str = "the path-traced picture";

/// Fills in what the plugin reports.
pub fn show(
    report: Res<VoxelGiReport>,
    truth: Res<Truth>,
    mut memory: ResMut<MemoryFigures>,
    mut notes: ResMut<Notes>,
    mut work: ResMut<AwaitedWork>,
) {
    let mut figures = MemoryFigures::default();
    figures.0.insert("volume before".into(), 0);
    figures.0.insert("volume after".into(), report.memory);
    memory.set_if_neq(figures);

    let state = match report.state {
        VoxelGiState::Absent => "getting ready",
        VoxelGiState::Running => "computed each frame",
        VoxelGiState::Settled => "settled: nothing is computed until something changes",
    };
    let receiver = if report.receiver_patched {
        "by the plugin's shader"
    } else {
        "as a plain irradiance volume of Bevy"
    };
    let mut texts = Notes::default();
    for (name, text) in [
        ("volume:", state.into()),
        ("triangles in it:", report.triangles.to_string()),
        ("read:", receiver.into()),
    ] {
        texts.0.insert(name.into(), text);
    }
    if let Some(text) = truth.note() {
        texts.0.insert("path tracing:".into(), text);
    }
    notes.set_if_neq(texts);

    for (name, is_waiting) in [
        (LIGHT, report.state != VoxelGiState::Settled),
        (TRUTH, truth.is_waiting()),
    ] {
        if is_waiting {
            work.0.insert(name);
        } else {
            work.0.remove(name);
        }
    }
}

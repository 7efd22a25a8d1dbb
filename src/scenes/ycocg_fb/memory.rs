//! The reports of the plugin as figures and notes.

use bevy::prelude::*;
use bevy_ycocg_fb::{CameraState, FrameBufferReports};

use crate::runner::{MemoryFigures, Notes, SceneSettings, Side};

/// Name of the note on what became of the packed camera.
const STATE: &str = "after:";
/// Name of the note on what the figures count.
const COUNTED: &str = "memory:";

/// Fills in what the cameras at the split took in the last frame. A camera that the line leaves no
/// room keeps its figures until a setting changes.
pub fn show(
    reports: Res<FrameBufferReports>,
    settings: Res<SceneSettings>,
    cameras: Query<(Entity, &Side), With<Camera>>,
    mut memory: ResMut<MemoryFigures>,
    mut notes: ResMut<Notes>,
) {
    let mut figures = memory.clone();
    let mut texts = notes.clone();
    if settings.is_changed() {
        figures.0.clear();
        texts.0.clear();
    }
    for (camera, side) in &cameras {
        let Some(report) = reports.get(camera) else {
            continue;
        };
        let name = match side {
            Side::Before => "before",
            Side::After => "after",
        };
        let taken = report.memory;
        if taken.total() == 0 {
            continue; // The frame is still being drawn, on another thread.
        }
        for (row, bytes) in [
            ("main", taken.main),
            ("main MSAA", taken.main_multisampled),
            ("packed", taken.packed),
            ("packed MSAA", taken.packed_multisampled),
            ("total", taken.total()),
        ] {
            figures.0.insert(format!("{row} {name}"), bytes);
        }
        match report.state {
            Some(CameraState::Packed) => texts.0.insert(STATE.into(), "packed".into()),
            Some(CameraState::Rg11b10Ufloat) => texts
                .0
                .insert(STATE.into(), "drawn by Bevy in Rg11b10Ufloat".into()),
            Some(CameraState::Fallback(reason)) => texts
                .0
                .insert(STATE.into(), format!("as Bevy draws it: {reason}")),
            None => None,
        };
    }
    texts.0.insert(
        COUNTED.into(),
        "colour of the whole target; a camera alone would take as much, and two with the same \
         settings share Bevy's main textures"
            .into(),
    );
    memory.set_if_neq(figures);
    notes.set_if_neq(texts);
}

//! The reports of the plugin as figures and notes.

use bevy::prelude::*;
use bevy_ycocg_fb::{CameraState, FrameBufferReport};

use crate::runner::{MemoryFigures, Notes, SceneSettings, Side};

/// Name of the note on what became of the packed camera.
const STATE: &str = "after:";
/// Name of the note on what the figures count.
const COUNTED: &str = "memory:";

/// Fills in what the cameras at the split took in the last frame. A camera that the line leaves no
/// room keeps its figures until a setting changes.
pub fn show(
    settings: Res<SceneSettings>,
    cameras: Query<(&FrameBufferReport, &Side), With<Camera>>,
    mut memory: ResMut<MemoryFigures>,
    mut notes: ResMut<Notes>,
) {
    let mut figures = memory.clone();
    let mut texts = notes.clone();
    if settings.is_changed() {
        figures.0.clear();
        texts.0.clear();
    }
    for (report, side) in &cameras {
        if report.state == CameraState::Pending {
            continue;
        }
        let name = match side {
            Side::Before => "before",
            Side::After => "after",
        };
        let taken = report.memory;
        for (row, bytes) in [
            ("main", taken.main),
            ("main MSAA", taken.main_multisampled),
            ("packed", taken.packed),
            ("packed MSAA", taken.packed_multisampled),
            ("total", taken.total()),
        ] {
            figures.0.insert(format!("{row} {name}"), bytes);
        }
        let text = match &report.state {
            CameraState::Packed(_) => "packed".into(),
            CameraState::Rg11b10Ufloat => "drawn by Bevy in Rg11b10Ufloat".into(),
            CameraState::Fallback(reason) => format!("as Bevy draws it: {reason}"),
            _ => continue,
        };
        texts.0.insert(STATE.into(), text);
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

//! What each plugin reports, as figures and notes.

use bevy::prelude::*;
use bevy_voxel_gi::{VoxelGiReport, VoxelGiState};
use bevy_ycocg_fb::{CameraState, FrameBufferReport};

use crate::{
    headless::AwaitedWork,
    runner::{MemoryFigures, Notes, SceneSettings, Side},
};

/// What a picture waits for, as it is called in messages: the light has settled.
pub const LIGHT: &str = "the light";

/// Bytes of the textures of each side, on the GPU.
#[derive(Resource, Clone, Copy, Debug, Default)]
pub struct TextureBytes {
    pub before: u64,
    pub after: u64,
}

/// Fills in what the plugins report.
pub fn show(
    settings: Res<SceneSettings>,
    textures: Res<TextureBytes>,
    light: Res<VoxelGiReport>,
    cameras: Query<(&FrameBufferReport, &Side), With<Camera>>,
    mut memory: ResMut<MemoryFigures>,
    mut notes: ResMut<Notes>,
    mut work: ResMut<AwaitedWork>,
) {
    let mut figures = memory.clone();
    let mut texts = notes.clone();
    let mut figure = |name: &str, bytes| figures.0.insert(name.into(), bytes);
    figure("textures before", textures.before);
    figure("textures after", textures.after);
    figure("volume before", 0);
    figure("volume after", light.memory);
    for (report, side) in &cameras {
        if report.state == CameraState::Pending {
            continue;
        }
        let taken = report.memory.total();
        match side {
            Side::Before => figure("frame buffer before", taken),
            Side::After => figure("frame buffer after", taken),
        };
        if *side == Side::After {
            let text = match &report.state {
                CameraState::Rg11b10Ufloat => "three small floats".into(),
                CameraState::Packed(_) => "packed".into(),
                CameraState::Fallback(reason) => format!("as Bevy draws it: {reason}"),
                _ => "Bevy's".into(),
            };
            texts.0.insert("frame buffer:".into(), text);
        }
    }
    let on = settings.toggle("voxel_gi");
    let state = match light.state {
        _ if !on => "off",
        VoxelGiState::Absent => "getting ready",
        VoxelGiState::Running => "computed each frame",
        VoxelGiState::Settled => "settled: nothing is computed until something changes",
    };
    texts.0.insert("light that bounces:".into(), state.into());
    memory.set_if_neq(figures);
    notes.set_if_neq(texts);

    if on && light.state != VoxelGiState::Settled {
        work.0.insert(LIGHT);
    } else {
        work.0.remove(LIGHT);
    }
}

//! What the settings make of the cameras.

use bevy::{camera::Hdr, prelude::*};
use bevy_ycocg_fb::{
    FrameBufferFormat, MsaaResolve, PackedFormat, Reconstruction, YCoCgFrameBuffer,
};

use crate::{
    runner::{SceneSettings, Side},
    scenes::error_view::Films,
};

/// Gives all cameras, new ones too, what the settings say.
pub fn apply_settings(
    mut commands: Commands,
    settings: Res<SceneSettings>,
    cameras: Query<(Entity, &Films)>,
    new: Query<(), Added<Films>>,
) {
    if !settings.is_changed() && new.is_empty() {
        return;
    }
    let frame_buffer = frame_buffer(&settings);
    let hdr = settings.toggle("hdr");
    let msaa = match settings.choice("msaa") {
        "4x" => Msaa::Sample4,
        _ => Msaa::Off,
    };
    for (entity, Films(side)) in &cameras {
        let mut camera = commands.entity(entity);
        camera.insert(msaa);
        let hdr = match side {
            // What a packed camera without `Hdr` is to look like: it blends scene-linear values.
            Side::Before => hdr || frame_buffer.format != PackedFormat::Unorm8.into(),
            Side::After => {
                camera.insert(frame_buffer);
                hdr
            }
        };
        if hdr {
            camera.insert(Hdr);
        } else {
            camera.remove::<Hdr>();
        }
    }
}

fn frame_buffer(settings: &SceneSettings) -> YCoCgFrameBuffer {
    YCoCgFrameBuffer {
        format: match settings.choice("format") {
            "float32" => PackedFormat::Float32.into(),
            "unorm8" => PackedFormat::Unorm8.into(),
            "rg11b10ufloat" => FrameBufferFormat::Rg11b10Ufloat,
            _ => PackedFormat::Float16.into(),
        },
        reconstruction: match settings.choice("reconstruction") {
            "nearest" => Reconstruction::Nearest,
            "bilinear" => Reconstruction::Bilinear,
            "edge_directed" => Reconstruction::EdgeDirected,
            "wide" => Reconstruction::Wide,
            "quad" => Reconstruction::Quad,
            _ => Reconstruction::Guided,
        },
        msaa_resolve: match settings.choice("msaa_resolve") {
            "tone_map_weighted" => MsaaResolve::ToneMapWeighted,
            _ => MsaaResolve::Box,
        },
    }
}

//! What the settings make of the cameras.

use bevy::{camera::Hdr, prelude::*};
use bevy_ycocg_fb::{
    FrameBufferQuality, MsaaResolve, PackedFormat, Reconstruction, YCoCgFrameBuffer,
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
    let quality = quality(&settings);
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
            Side::Before => {
                camera.insert(FrameBufferQuality::Exact);
                hdr || settings.choice("format") != "unorm8"
            }
            Side::After => {
                camera.insert(quality);
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

fn quality(settings: &SceneSettings) -> FrameBufferQuality {
    let format = match settings.choice("format") {
        "float32" => PackedFormat::Float32,
        "unorm8" => PackedFormat::Unorm8,
        "rg11b10ufloat" => return FrameBufferQuality::Compact,
        _ => PackedFormat::Float16,
    };
    FrameBufferQuality::Packed(YCoCgFrameBuffer {
        format,
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
    })
}

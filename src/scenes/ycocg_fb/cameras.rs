//! What the knobs make of the cameras.

use bevy::{camera::Hdr, prelude::*};
use bevy_ycocg_fb::{MsaaResolve, PackedFormat, Reconstruction, YCoCgFrameBuffer};

use crate::{
    runner::{Knobs, Side},
    scenes::error_view::Films,
};

/// Gives all cameras, new ones too, what the knobs say.
pub fn apply_knobs(
    mut commands: Commands,
    knobs: Res<Knobs>,
    cameras: Query<(Entity, &Films)>,
    new: Query<(), Added<Films>>,
) {
    if !knobs.is_changed() && new.is_empty() {
        return;
    }
    let settings = settings(&knobs);
    let hdr = knobs.toggle("hdr");
    let msaa = match knobs.choice("msaa") {
        "4x" => Msaa::Sample4,
        _ => Msaa::Off,
    };
    for (entity, Films(side)) in &cameras {
        let mut camera = commands.entity(entity);
        camera.insert(msaa);
        let hdr = match side {
            // What a packed camera without `Hdr` is to look like: it blends scene-linear values.
            Side::Before => hdr || settings.format != PackedFormat::Unorm8,
            Side::After => {
                camera.insert(settings);
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

fn settings(knobs: &Knobs) -> YCoCgFrameBuffer {
    YCoCgFrameBuffer {
        format: match knobs.choice("format") {
            "float32" => PackedFormat::Float32,
            "unorm8" => PackedFormat::Unorm8,
            _ => PackedFormat::Float16,
        },
        reconstruction: match knobs.choice("reconstruction") {
            "nearest" => Reconstruction::Nearest,
            "bilinear" => Reconstruction::Bilinear,
            "edge_directed" => Reconstruction::EdgeDirected,
            "wide" => Reconstruction::Wide,
            "quad" => Reconstruction::Quad,
            _ => Reconstruction::Guided,
        },
        msaa_resolve: match knobs.choice("msaa_resolve") {
            "tone_map_weighted" => MsaaResolve::ToneMapWeighted,
            _ => MsaaResolve::Box,
        },
    }
}

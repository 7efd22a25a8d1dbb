//! How the colours of a camera are mapped to the display, and a camera that shows one quad.

use bevy::{
    camera::{CameraOutputMode, ScalingMode, Viewport, visibility::RenderLayers},
    core_pipeline::tonemapping::{DebandDither, Tonemapping},
    prelude::*,
    render::render_resource::BlendState,
};

use crate::{headless::LabTarget, runner::AFTER_LAYER};

/// Bevy's default for a `Camera3d`: it tone-maps and dithers.
pub const TONE_MAPPED: (Tonemapping, DebandDither) =
    (Tonemapping::TonyMcMapface, DebandDither::Enabled);

/// The camera writes its colours unchanged. Bevy does not dither without tone mapping, and warns of cameras
/// that ask for it.
pub const UNGRADED: (Tonemapping, DebandDither) = (Tonemapping::None, DebandDither::Disabled);

pub const LAYER: usize = AFTER_LAYER + 1;

/// Fills `area`, in pixels of the target, with a quad of 1 x 1 at the origin.
pub fn quad_camera(area: URect, target: &LabTarget) -> impl Bundle + use<> {
    (
        Camera2d,
        Camera {
            order: LAYER as isize,
            viewport: Some(Viewport {
                physical_position: area.min,
                physical_size: area.size(),
                ..default()
            }),
            output_mode: CameraOutputMode::Write {
                blend_state: Some(BlendState::REPLACE),
                clear_color: ClearColorConfig::None,
            },
            ..default()
        },
        Projection::from(OrthographicProjection {
            scaling_mode: ScalingMode::Fixed {
                width: 1.0,
                height: 1.0,
            },
            ..OrthographicProjection::default_2d()
        }),
        target.0.clone(),
        RenderLayers::layer(LAYER),
        Msaa::Off,
        Tonemapping::None,
        DebandDither::Disabled,
    )
}

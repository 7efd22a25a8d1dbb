//! A view in which one unit is one pixel, to show textures as they are.

use bevy::{
    camera::ScalingMode,
    core_pipeline::tonemapping::{DebandDither, Tonemapping},
    prelude::*,
};

use super::LabTarget;

/// A camera that sees a rectangle of `size` units around the origin, from +Z, pixel by pixel:
/// orthographic, without multisampling, tone mapping and dithering.
pub fn pixel_camera(target: &LabTarget, [width, height]: [u32; 2]) -> impl Bundle {
    let scaling_mode = ScalingMode::Fixed {
        width: width as f32,
        height: height as f32,
    };
    (
        Camera3d::default(),
        target.0.clone(),
        Msaa::Off,
        Tonemapping::None,
        DebandDither::Disabled,
        Projection::from(OrthographicProjection {
            scaling_mode,
            ..OrthographicProjection::default_3d()
        }),
        Transform::from_xyz(0.0, 0.0, 10.0),
    )
}

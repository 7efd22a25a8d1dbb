//! Lights, sky and camera of a scene, in plain numbers.
//!
//! Metres, right-handed, Y up; light per channel.

mod spawn;

use bevy::math::Vec3;
use serde::Deserialize;

pub use spawn::{StageCamera, spawn_camera, spawn_lights};

/// What illuminates a scene, and the camera of its picture.
#[derive(Clone, Debug)]
pub struct Stage {
    /// Lights without size.
    pub point_lights: Vec<ScenePointLight>,
    /// Lights that are infinitely far away.
    pub directional_lights: Vec<SceneDirectionalLight>,
    /// Radiance of the sky, in candela per square metre.
    pub sky_radiance: Vec3,
    /// The camera of the picture.
    pub camera: SceneCamera,
}

/// Centre and edge of the smallest cube of this many voxels along an edge that leaves one free on each side of
/// these bounds.
pub fn volume_around((low, high): (Vec3, Vec3), resolution: u32) -> (Vec3, f32) {
    let voxel = (high - low).max_element() / (resolution - 2) as f32;
    (0.5 * (low + high), voxel * resolution as f32)
}

/// A light without size.
#[derive(Clone, Copy, Debug, Deserialize)]
pub struct ScenePointLight {
    /// The position of the light in metres.
    pub position: Vec3,
    /// Luminous intensity in candela.
    pub intensity_cd: Vec3,
}

/// Parallel light.
#[derive(Clone, Copy, Debug, Deserialize)]
pub struct SceneDirectionalLight {
    /// The direction in which the light travels, of any length.
    pub direction: Vec3,
    /// Illuminance in lux of a surface that faces the light, per channel.
    pub illuminance_lux: Vec3,
}

/// A camera.
#[derive(Clone, Copy, Debug, Deserialize)]
pub struct SceneCamera {
    /// The position of the camera in metres.
    pub eye: Vec3,
    /// The point in the middle of the picture, in metres.
    pub target: Vec3,
    /// The direction that is up in the picture.
    pub up: Vec3,
    /// Vertical field of view in degrees.
    pub fov_y_deg: f32,
    /// Width of its picture in pixels.
    pub width: u32,
    /// Height of its picture in pixels.
    pub height: u32,
}

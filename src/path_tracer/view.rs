//! The rays of a camera.

use bevy::math::{Mat3, Vec2, Vec3};

use super::surfaces::Ray;
use crate::stage::SceneCamera;

/// The rays of a camera.
#[derive(Clone, Copy, Debug)]
pub struct View {
    eye: Vec3,
    size: Vec2,
    /// The camera's right, up and forward, the first two half as long as the picture at distance 1.
    axes: Mat3,
}

impl View {
    pub fn new(camera: &SceneCamera) -> Self {
        let forward = (camera.target - camera.eye).normalize();
        let right = forward.cross(camera.up).normalize();
        let half_height = (0.5 * camera.fov_y_deg.to_radians()).tan();
        let half_width = half_height * camera.width as f32 / camera.height as f32;
        Self {
            eye: camera.eye,
            size: Vec2::new(camera.width as f32, camera.height as f32),
            axes: Mat3::from_cols(
                right * half_width,
                right.cross(forward) * half_height,
                forward,
            ),
        }
    }

    /// The ray through a point of the picture, in pixels from the top left.
    pub fn ray(&self, pixel: Vec2) -> Ray {
        let at = pixel / self.size;
        let at = Vec2::new(2.0 * at.x - 1.0, 1.0 - 2.0 * at.y);
        Ray {
            origin: self.eye,
            direction: (self.axes * at.extend(1.0)).normalize(),
        }
    }
}

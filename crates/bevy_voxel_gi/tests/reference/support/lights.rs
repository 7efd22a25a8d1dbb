//! Lights without color, in scenes whose unit is a meter.

use bevy_voxel_gi::reference::Light;
use glam::Vec3;

/// A light from afar, in lux, shining in this direction.
pub fn sun(direction: Vec3, lux: f32) -> Light {
    Light::Directional {
        direction: direction.normalize(),
        illuminance: Vec3::splat(lux),
    }
}

/// A light to all sides, in candela.
pub fn point_light(position: Vec3, candela: f32) -> Light {
    Light::Point {
        position,
        intensity: Vec3::splat(candela),
        cone: None,
        near: 0.0,
    }
}

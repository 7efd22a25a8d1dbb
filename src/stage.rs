//! Lights, sky and camera of a scene, in plain numbers.
//!
//! Metres, right-handed, Y up; light per channel.

use bevy::{
    camera::{Exposure, Hdr},
    core_pipeline::tonemapping::{DebandDither, Tonemapping},
    math::Vec3,
    prelude::*,
};
use serde::Deserialize;

use crate::headless::LabTarget;

/// What illuminates a scene, and the camera of its picture.
#[derive(Clone, Debug)]
pub struct Stage {
    /// Lights without size.
    pub point_lights: Vec<ScenePointLight>,
    /// Lights that are infinitely far away.
    pub directional_lights: Vec<SceneDirectionalLight>,
    /// Radiance of the sky, in candela per square metre.
    pub sky_radiance: Vec3,
    /// What the quarter of the sky at +X and +Z has beyond that.
    pub sky_quarter: Vec3,
    /// The camera of the picture.
    pub camera: SceneCamera,
}

impl Stage {
    /// Radiance of the sky in a direction.
    pub fn sky(&self, direction: Vec3) -> Vec3 {
        let is_bright = direction.x > 0.0 && direction.z > 0.0;
        self.sky_radiance + self.sky_quarter * f32::from(u8::from(is_bright))
    }
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

impl SceneCamera {
    /// Its position and rotation.
    pub fn pose(&self) -> Transform {
        Transform::from_translation(self.eye).looking_at(self.target, self.up)
    }
}

/// The camera of the picture.
#[derive(Component)]
pub struct StageCamera;

/// Spawns lights in the scene's units, point lights first.
pub fn spawn_lights(
    world: &mut World,
    point_lights: &[ScenePointLight],
    directional_lights: &[SceneDirectionalLight],
) -> Vec<Entity> {
    let mut spawned = Vec::new();
    for light in point_lights {
        let (color, strength) = color_and_strength(light.intensity_cd);
        let entity = world.spawn((
            PointLight {
                color,
                intensity: strength * 4.0 * std::f32::consts::PI,
                // Bevy fades lights out at their range; physics does not.
                range: 1e4,
                shadow_maps_enabled: true,
                ..default()
            },
            Transform::from_translation(light.position),
        ));
        spawned.push(entity.id());
    }
    for sun in directional_lights {
        let (color, illuminance) = color_and_strength(sun.illuminance_lux);
        let entity = world.spawn((
            DirectionalLight {
                color,
                illuminance,
                shadow_maps_enabled: true,
                ..default()
            },
            Transform::default().looking_to(sun.direction, Vec3::Y),
        ));
        spawned.push(entity.id());
    }
    spawned
}

/// Spawns the camera, without any ambient light around it.
pub fn spawn_camera(world: &mut World, view: &SceneCamera) -> Entity {
    let target = world.resource::<LabTarget>().0.clone();
    world.insert_resource(GlobalAmbientLight::NONE);
    world.insert_resource(ClearColor(Color::BLACK));
    let camera = world.spawn((
        StageCamera,
        Camera3d::default(),
        Hdr,
        target,
        Msaa::Off,
        Tonemapping::None,
        DebandDither::Disabled,
        // An exposure of exactly 1.
        Exposure {
            ev100: -(1.2_f32.log2()),
        },
        Projection::Perspective(PerspectiveProjection {
            fov: view.fov_y_deg.to_radians(),
            aspect_ratio: view.width as f32 / view.height as f32,
            ..default()
        }),
        view.pose(),
    ));
    camera.id()
}

/// A colour whose largest channel is 1, and the factor to it.
fn color_and_strength(light: Vec3) -> (Color, f32) {
    let strength = light.max_element();
    let color = light / strength.max(f32::MIN_POSITIVE);
    (LinearRgba::from_vec3(color).into(), strength)
}

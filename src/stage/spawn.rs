//! Lights and camera in Bevy, in units of the scene: a pixel's value is its radiance.

use bevy::{
    camera::{Exposure, Hdr},
    core_pipeline::tonemapping::{DebandDither, Tonemapping},
    prelude::*,
};

use super::{SceneCamera, SceneDirectionalLight, ScenePointLight};
use crate::headless::LabTarget;

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
pub fn spawn_camera(world: &mut World, view: &SceneCamera) {
    let target = world.resource::<LabTarget>().0.clone();
    world.insert_resource(GlobalAmbientLight::NONE);
    world.insert_resource(ClearColor(Color::BLACK));
    world.spawn((
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
        Transform::from_translation(view.eye).looking_at(view.target, view.up),
    ));
}

/// A colour whose largest channel is 1, and the factor to it.
fn color_and_strength(light: Vec3) -> (Color, f32) {
    let strength = light.max_element();
    let color = light / strength.max(f32::MIN_POSITIVE);
    (LinearRgba::from_vec3(color).into(), strength)
}

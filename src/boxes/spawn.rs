//! A scene of boxes in Bevy, in units of the scene: a pixel's value is its radiance.

use bevy::{
    camera::{Exposure, Hdr},
    core_pipeline::tonemapping::{DebandDither, Tonemapping},
    prelude::*,
};

use super::BoxScene;
use crate::headless::LabTarget;

/// The camera of a scene of boxes.
#[derive(Component)]
pub struct BoxSceneCamera;

/// Spawns boxes and lamps in the scene's units, boxes first; the sky is left out.
pub fn spawn_boxes_and_lamps(world: &mut World, scene: &BoxScene) -> Vec<Entity> {
    let mut spawned = Vec::new();
    let mesh = world
        .resource_mut::<Assets<Mesh>>()
        .add(Cuboid::from_size(Vec3::splat(2.0)));
    for part in &scene.boxes {
        let material = world
            .resource_mut::<Assets<StandardMaterial>>()
            .add(StandardMaterial {
                base_color: LinearRgba::from_vec3(part.albedo).into(),
                perceptual_roughness: 1.0,
                reflectance: 0.0,
                ..default()
            });
        let entity = world.spawn((
            Mesh3d(mesh.clone()),
            MeshMaterial3d(material),
            Transform::from_translation(part.center)
                .with_rotation(part.rotation())
                .with_scale(part.half),
        ));
        spawned.push(entity.id());
    }
    for lamp in &scene.point_lights {
        let (color, strength) = color_and_strength(lamp.intensity_cd);
        let entity = world.spawn((
            PointLight {
                color,
                intensity: strength * 4.0 * std::f32::consts::PI,
                // Bevy fades lamps out at their range; physics does not.
                range: 1e4,
                shadow_maps_enabled: true,
                ..default()
            },
            Transform::from_translation(lamp.position),
        ));
        spawned.push(entity.id());
    }
    for sun in &scene.directional_lights {
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

/// Spawns boxes, lamps and camera; the sky is left out.
pub fn spawn_box_scene(world: &mut World, scene: &BoxScene) {
    let target = world.resource::<LabTarget>().0.clone();
    world.insert_resource(GlobalAmbientLight::NONE);
    world.insert_resource(ClearColor(Color::BLACK));
    spawn_boxes_and_lamps(world, scene);
    let view = scene.camera;
    world.spawn((
        BoxSceneCamera,
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

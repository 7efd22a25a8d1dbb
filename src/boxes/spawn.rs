//! A scene of boxes in Bevy, in units of the scene: a pixel's value is its radiance.

use bevy::prelude::*;

use super::BoxScene;
use crate::stage::{spawn_camera, spawn_lights};

/// Spawns boxes and lights in the scene's units, boxes first; the sky is left out.
pub fn spawn_boxes_and_lights(world: &mut World, scene: &BoxScene) -> Vec<Entity> {
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
    spawned.extend(spawn_lights(
        world,
        &scene.point_lights,
        &scene.directional_lights,
    ));
    spawned
}

/// Spawns boxes, lights and camera; the sky is left out. Boxes and lights are returned, boxes first.
pub fn spawn_box_scene(world: &mut World, scene: &BoxScene) -> Vec<Entity> {
    let spawned = spawn_boxes_and_lights(world, scene);
    spawn_camera(world, &scene.camera);
    spawned
}

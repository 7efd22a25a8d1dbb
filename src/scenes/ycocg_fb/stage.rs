//! The chosen scene, and its slow motion.

use std::f32::consts::TAU;

use bevy::{camera_controller::free_camera::FreeCameraState, prelude::*};

use super::scenes::{SCENES, TestScene};
use crate::{
    runner::{PictureArea, SceneSettings},
    scenes::error_view::Films,
};

/// Seconds of a movement there and back.
const PERIOD: f32 = 20.0;
/// How far the sun wanders to each side, in radians.
const SUN: f32 = 0.4;
/// How far scenes in pixels drift to each side, in pixels.
const DRIFT: f32 = 6.0;

/// Which scene is on stage, and for which size of the picture where it depends on that.
#[derive(Resource, Default)]
pub struct Stage(Option<(&'static str, UVec2)>);

/// A part of the scene, where it belongs.
#[derive(Component)]
pub struct Part(Transform);

/// Puts the chosen scene on stage, and the cameras before it.
pub fn change(world: &mut World) {
    let area = world.resource::<PictureArea>().0.size();
    if area.min_element() == 0 {
        return;
    }
    let name = world.resource::<SceneSettings>().choice("scene");
    let Some(scene) = SCENES.iter().find(|scene| scene.name == name) else {
        return;
    };
    let size = if scene.is_in_pixels() {
        area
    } else {
        UVec2::ZERO
    };
    let now = world.resource::<Stage>().0;
    if now == Some((name, size)) {
        return;
    }
    world.resource_mut::<Stage>().0 = Some((name, size));
    let mut parts = world.query_filtered::<Entity, With<Part>>();
    for part in parts.iter(world).collect::<Vec<_>>() {
        world.despawn(part);
    }
    for part in scene.spawn_content(world, area) {
        let mut part = world.entity_mut(part);
        let pose = part.get::<Transform>().copied().unwrap_or_default();
        part.insert(Part(pose));
    }
    place_cameras(world, scene, area);
}

fn place_cameras(world: &mut World, scene: &TestScene, area: UVec2) {
    let mut cameras = world.query_filtered::<Entity, With<Films>>();
    for camera in cameras.iter(world).collect::<Vec<_>>() {
        let mut camera = world.entity_mut(camera);
        camera.insert(scene.camera(area));
        // It would turn back to where it looked before.
        if camera.contains::<FreeCameraState>() {
            camera.insert(FreeCameraState::default());
        }
    }
}

/// Moves the sun, or everything where there is none. At time 0 all is where it belongs.
pub fn drift(
    settings: Res<SceneSettings>,
    time: Res<Time>,
    mut parts: Query<(&Part, &mut Transform, Has<DirectionalLight>)>,
) {
    let phase = if settings.toggle("motion") {
        (time.elapsed_secs() * TAU / PERIOD).sin()
    } else {
        0.0
    };
    let has_sun = parts.iter().any(|(_, _, is_sun)| is_sun);
    for (Part(home), mut pose, is_sun) in &mut parts {
        let mut moved = *home;
        if is_sun {
            moved.rotate_around(Vec3::ZERO, Quat::from_rotation_y(phase * SUN));
        } else if !has_sun {
            moved.translation.x += phase * DRIFT;
        }
        pose.set_if_neq(moved);
    }
}

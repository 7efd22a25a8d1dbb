//! Values far out, and such as are no numbers.

use bevy::{math::Affine2, prelude::*};
use bevy_voxel_gi::VoxelGiVolume;

use super::stage::{Eye, Middle, change_filtered, change_materials, difference, full_app, picture};
use crate::support::gpu;

const MAGNITUDES: [f32; 8] = [
    0.0,
    1e-30,
    1e-7,
    1e7,
    1e30,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::NAN,
];

/// Asserts that every magnitude leaves the picture finite, and that it heals once it is gone.
fn endures(what: &str, set: impl Fn(&mut World, f32), usual: f32) {
    let _gpu = gpu();
    let mut app = full_app();
    set(app.world_mut(), usual);
    let before = picture(&mut app, 60);
    for value in MAGNITUDES {
        println!("{what}: {value}");
        set(app.world_mut(), value);
        picture(&mut app, 3);
    }
    set(app.world_mut(), usual);
    let left = difference(&before, &picture(&mut app, 60));
    println!("{what}: {left} once it is gone");
    assert!(left < 0.02, "{what} leaves something behind: {left}");
}

#[test]
fn emission_of_any_magnitude() {
    let set = |world: &mut World, value: f32| {
        let emissive = LinearRgba::rgb(value, 0.5 * value, 0.0);
        change_materials(world, |base| base.emissive = emissive);
    };
    endures("emission", set, 0.0);
}

#[test]
fn lights_of_any_strength() {
    let set = |world: &mut World, value: f32| {
        let mut lights = world.query::<&mut DirectionalLight>();
        for mut light in lights.iter_mut(world) {
            light.illuminance = value;
        }
    };
    endures("illuminance", set, 8000.0);
}

#[test]
fn texture_coordinates_of_any_scale() {
    let set = |world: &mut World, value: f32| {
        let scale = Affine2::from_scale(Vec2::splat(value));
        change_materials(world, |base| base.uv_transform = scale);
    };
    endures("texture coordinates", set, 4.0);
}

#[test]
fn colours_of_any_magnitude() {
    let set = |world: &mut World, value: f32| {
        let color = Color::linear_rgb(value, 1.0, 0.5);
        change_filtered(world, |base| base.base_color = color);
    };
    endures("base colour", set, 0.8);
}

#[test]
fn poses_of_any_magnitude() {
    let set = |world: &mut World, value: f32| {
        let mut things = world.query_filtered::<&mut Transform, With<Middle>>();
        for mut pose in things.iter_mut(world) {
            pose.scale = Vec3::new(value, 1.0, 1.0);
            pose.translation.z = if value == 1.0 { 0.0 } else { value };
        }
    };
    endures("pose", set, 1.0);
}

#[test]
fn cameras_anywhere() {
    let set = |world: &mut World, value: f32| {
        let mut eyes = world.query_filtered::<&mut Transform, With<Eye>>();
        for mut pose in eyes.iter_mut(world) {
            pose.translation = Vec3::new(0.3, 1.2, value);
        }
    };
    endures("camera", set, 3.0);
}

#[test]
fn volumes_of_any_size() {
    let set = |world: &mut World, value: f32| {
        let mut volumes = world.query::<&mut VoxelGiVolume>();
        for mut volume in volumes.iter_mut(world) {
            volume.size = value;
        }
    };
    endures("volume", set, 8.0);
}

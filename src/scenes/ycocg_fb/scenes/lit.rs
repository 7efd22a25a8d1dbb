//! A courtyard with coloured things in it, as a game might show.

use std::f32::consts::FRAC_PI_2;

use bevy::{
    light::{CascadeShadowConfigBuilder, GlobalAmbientLight},
    math::Affine2,
    prelude::*,
};

use crate::{
    content,
    scenes::ycocg_fb::scenes::{
        scene::{TestScene, View},
        shapes::{SEED, add, textured},
    },
};

pub(super) const SCENE: TestScene = TestScene {
    name: "lit",
    description: "brick wall, wooden floor and coloured bodies in the sun, with shadows",
    view: View::Perspective {
        eye: Vec3::new(0.6, 1.7, 4.2),
        target: Vec3::new(0.0, 0.75, 0.0),
    },
    spawn,
};

fn spawn(world: &mut World, _: UVec2) {
    surroundings(world);
    bodies(world);
    lights(world);
}

fn surroundings(world: &mut World) {
    let wall = textured(world, content::bricks(256, 256, SEED));
    let floor = textured(world, content::wood(256, 256, SEED));
    let plane = |width: f32, height: f32, repeat: Vec2| {
        let mesh = Mesh::from(Rectangle::new(width, height));
        let mesh = mesh.with_generated_tangents().expect("positions and UVs");
        (mesh, Affine2::from_scale(repeat))
    };
    let (mesh, uv_transform) = plane(9.0, 4.0, Vec2::new(4.5, 2.0));
    let wall = StandardMaterial {
        uv_transform,
        perceptual_roughness: 0.9,
        ..wall
    };
    add(world, mesh, wall, Transform::from_xyz(0.0, 2.0, -1.4));
    let (mesh, uv_transform) = plane(9.0, 7.0, Vec2::new(3.0, 7.0 / 3.0));
    let floor = StandardMaterial {
        uv_transform,
        perceptual_roughness: 0.45,
        ..floor
    };
    let pose = Transform::from_xyz(0.0, 0.0, 2.0).with_rotation(Quat::from_rotation_x(-FRAC_PI_2));
    add(world, mesh, floor, pose);
}

fn bodies(world: &mut World) {
    let paint = |red: f32, green: f32, blue: f32| StandardMaterial {
        base_color: Color::srgb(red, green, blue),
        perceptual_roughness: 0.35,
        ..default()
    };
    let ball = |radius: f32| Sphere::new(radius).mesh().uv(48, 32);
    add(
        world,
        ball(0.55),
        paint(0.75, 0.08, 0.06),
        Transform::from_xyz(-1.35, 0.55, 0.0),
    );
    add(
        world,
        ball(0.3),
        paint(0.95, 0.72, 0.1),
        Transform::from_xyz(-0.45, 0.3, 1.3),
    );
    add(
        world,
        Cuboid::new(0.8, 1.5, 0.8),
        paint(0.1, 0.3, 0.75),
        Transform::from_xyz(1.3, 0.75, -0.4).with_rotation(Quat::from_rotation_y(0.6)),
    );
    add(
        world,
        Torus::new(0.22, 0.5).mesh().build(),
        paint(0.1, 0.55, 0.2),
        Transform::from_xyz(0.2, 0.72, -0.2).with_rotation(Quat::from_rotation_x(1.25)),
    );
    let gold = StandardMaterial {
        metallic: 1.0,
        ..paint(1.0, 0.77, 0.34)
    };
    add(
        world,
        Cylinder::new(0.3, 0.5),
        gold,
        Transform::from_xyz(0.75, 0.25, 1.1),
    );
}

fn lights(world: &mut World) {
    let shadows = CascadeShadowConfigBuilder {
        num_cascades: 1,
        maximum_distance: 12.0,
        ..default()
    };
    world.spawn((
        DirectionalLight {
            color: Color::srgb(1.0, 0.95, 0.85),
            illuminance: 9000.0,
            shadow_maps_enabled: true,
            ..default()
        },
        shadows.build(),
        Transform::from_xyz(-2.0, 3.0, 2.5).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    world.insert_resource(GlobalAmbientLight {
        color: Color::srgb(0.75, 0.85, 1.0),
        brightness: 400.0,
        ..default()
    });
}

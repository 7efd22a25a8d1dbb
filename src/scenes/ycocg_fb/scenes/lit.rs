//! Lit scenes, as a game might show them.

use std::f32::consts::FRAC_PI_2;

use bevy::{
    light::{CascadeShadowConfigBuilder, GlobalAmbientLight},
    math::Affine2,
    prelude::*,
};

use super::{
    TestScene, View,
    shapes::{Random, SEED, add, textured},
};
use crate::content::{self, mipped_texture};

/// A courtyard with coloured things in it.
pub(super) const LIT: TestScene = TestScene {
    name: "lit",
    description: "brick wall, wooden floor and coloured bodies in the sun, with shadows",
    view: View::Perspective {
        eye: Vec3::new(0.6, 1.7, 4.2),
        target: Vec3::new(0.0, 0.75, 0.0),
    },
    spawn: spawn_lit,
};

fn spawn_lit(world: &mut World, _: UVec2) {
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
    spawn_sun(world, 9000.0, Vec3::new(-2.0, 3.0, 2.5), 12.0);
    world.insert_resource(GlobalAmbientLight {
        color: Color::srgb(0.75, 0.85, 1.0),
        brightness: 400.0,
        ..default()
    });
}

/// A sun of this illuminance in lux that shines from a place towards the origin, with shadows up to a distance.
fn spawn_sun(world: &mut World, illuminance: f32, from: Vec3, maximum_distance: f32) {
    let shadows = CascadeShadowConfigBuilder {
        num_cascades: 1,
        maximum_distance,
        ..default()
    };
    world.spawn((
        DirectionalLight {
            color: Color::srgb(1.0, 0.95, 0.85),
            illuminance,
            shadow_maps_enabled: true,
            ..default()
        },
        shadows.build(),
        Transform::from_translation(from).looking_at(Vec3::ZERO, Vec3::Y),
    ));
}

/// The courtyard by moonlight.
pub(super) const DARK: TestScene = TestScene {
    name: "dark",
    description: "the lit scene by moonlight, a fiftieth as bright",
    spawn: spawn_dark,
    ..LIT
};

const MOONLIGHT: f32 = 1.0 / 50.0;

fn spawn_dark(world: &mut World, size: UVec2) {
    spawn_lit(world, size);
    let mut lights = world.query::<&mut DirectionalLight>();
    for mut light in lights.iter_mut(world) {
        light.illuminance *= MOONLIGHT;
        light.color = Color::srgb(0.7, 0.85, 1.0);
    }
    world.resource_mut::<GlobalAmbientLight>().brightness *= MOONLIGHT;
    world.insert_resource(ClearColor(Color::BLACK));
}

/// A thicket: leaves a few pixels large, before a sky that shows through.
pub(super) const FOLIAGE: TestScene = TestScene {
    name: "foliage",
    description: "cards of leaves with masks, in layers, lit, before the sky",
    view: View::Perspective {
        eye: Vec3::new(0.0, 0.2, 4.0),
        target: Vec3::ZERO,
    },
    spawn: spawn_foliage,
};

fn spawn_foliage(world: &mut World, _: UVec2) {
    let leaves = content::foliage(256, 256, SEED);
    let masked = leaves.masked_color();
    let normal = image::DynamicImage::from(leaves.normal).into_rgba8();
    let mut images = world.resource_mut::<Assets<Image>>();
    let leaf = StandardMaterial {
        base_color_texture: Some(images.add(mipped_texture(&masked, true))),
        normal_map_texture: Some(images.add(mipped_texture(&normal, false))),
        alpha_mode: AlphaMode::Mask(0.5),
        double_sided: true,
        cull_mode: None,
        perceptual_roughness: 0.7,
        ..default()
    };
    let mut random = Random::new(5);
    for i in 0..18 {
        let card = Mesh::from(Rectangle::new(2.0, 2.0));
        let card = card.with_generated_tangents().expect("positions and UVs");
        let material = StandardMaterial {
            uv_transform: Affine2::from_scale_angle_translation(
                Vec2::splat(random.between(1.5, 3.0)),
                0.0,
                Vec2::new(random.next(), random.next()),
            ),
            ..leaf.clone()
        };
        let pose = Transform::from_xyz(
            random.between(-1.8, 1.8),
            random.between(-1.6, 1.6),
            i as f32 * 0.1 - 1.2,
        )
        .with_rotation(Quat::from_euler(
            EulerRot::YXZ,
            random.between(-0.9, 0.9),
            random.between(-0.7, 0.7),
            random.between(-3.0, 3.0),
        ));
        add(world, card, material, pose);
    }
    world.insert_resource(ClearColor(Color::srgb(0.55, 0.7, 0.9)));
    world.insert_resource(GlobalAmbientLight {
        color: Color::srgb(0.8, 0.9, 1.0),
        brightness: 500.0,
        ..default()
    });
    spawn_sun(world, 10_000.0, Vec3::new(-1.0, 2.0, 2.5), 10.0);
}

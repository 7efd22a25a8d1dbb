//! A thicket: leaves a few pixels large, before a sky that shows through.

use bevy::{
    light::{CascadeShadowConfigBuilder, GlobalAmbientLight},
    math::Affine2,
    prelude::*,
};
use image::Rgba;

use crate::{
    content::{self, mipped_texture},
    scenes::ycocg_fb::scenes::{
        scene::{TestScene, View},
        shapes::{Random, SEED, add},
    },
};

pub(super) const SCENE: TestScene = TestScene {
    name: "foliage",
    description: "cards of leaves with masks, in layers, lit, before the sky",
    view: View::Perspective {
        eye: Vec3::new(0.0, 0.2, 4.0),
        target: Vec3::ZERO,
    },
    spawn,
};

fn spawn(world: &mut World, _: UVec2) {
    let leaves = content::foliage(256, 256, SEED);
    let masked = image::RgbaImage::from_fn(256, 256, |x, y| {
        let [r, g, b] = leaves.color.get_pixel(x, y).0;
        Rgba([r, g, b, leaves.mask.get_pixel(x, y).0[0]])
    });
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
    let shadows = CascadeShadowConfigBuilder {
        num_cascades: 1,
        maximum_distance: 10.0,
        ..default()
    };
    world.spawn((
        DirectionalLight {
            color: Color::srgb(1.0, 0.95, 0.85),
            illuminance: 10_000.0,
            shadow_maps_enabled: true,
            ..default()
        },
        shadows.build(),
        Transform::from_xyz(-1.0, 2.0, 2.5).looking_at(Vec3::ZERO, Vec3::Y),
    ));
}

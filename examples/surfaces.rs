//! Light takes its colour, its source and its shadow from textures: a rug of two colours, a sign whose map glows in two
//! rings, and a fence that an alpha mask cuts out, before a tube of light.
//!
//! Space: light on and off.

mod common;

use bevy::{
    asset::RenderAssetUsages,
    camera::Exposure,
    camera_controller::free_camera::FreeCamera,
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};
use bevy_voxel_gi::{VoxelGiPlugin, VoxelGiSettings, VoxelGiVolume};

fn main() -> AppExit {
    App::new()
        .add_plugins((common::plugins(), VoxelGiPlugin))
        .insert_resource(GlobalAmbientLight::NONE)
        .insert_resource(ClearColor(Color::BLACK))
        .add_systems(Startup, spawn)
        .add_systems(Update, switch)
        .run()
}

/// An image of 128 x 128 pixels, whose colour at a place from 0 to 1 along both axes is given.
fn paint(color: impl Fn(Vec2) -> [u8; 4]) -> Image {
    const SIZE: u32 = 128;
    let place = |i: u32| (Vec2::new((i % SIZE) as f32, (i / SIZE) as f32) + 0.5) / SIZE as f32;
    let texels = (0..SIZE * SIZE).flat_map(|i| color(place(i))).collect();
    let mut size = Extent3d::default();
    (size.width, size.height) = (SIZE, SIZE);
    let format = TextureFormat::Rgba8UnormSrgb;
    let usage = RenderAssetUsages::RENDER_WORLD;
    Image::new(size, TextureDimension::D2, texels, format, usage)
}

fn spawn(
    mut commands: Commands,
    mut images: ResMut<Assets<Image>>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    commands.spawn((
        VoxelGiVolume::fixed(12.0),
        Transform::from_xyz(0.0, 2.0, -1.0),
    ));
    commands.insert_resource(VoxelGiSettings {
        resolution: 64,
        ..default()
    });
    commands.spawn((
        Camera3d::default(),
        FreeCamera::default(),
        Exposure { ev100: 4.5 },
        Transform::from_xyz(0.0, 6.6, 8.0).looking_at(Vec3::new(0.0, 0.5, -0.6), Vec3::Y),
    ));

    commands.spawn((
        SpotLight {
            intensity: 120_000.0,
            outer_angle: 0.65,
            shadow_maps_enabled: true,
            ..default()
        },
        Transform::from_xyz(-3.25, 2.7, 0.2).looking_to(Vec3::NEG_Y, Vec3::X),
    ));
    let mut add = |mesh: Mesh, material: StandardMaterial, x: f32, y: f32, z: f32| {
        commands.spawn((
            Mesh3d(meshes.add(mesh)),
            MeshMaterial3d(materials.add(material)),
            Transform::from_xyz(x, y, z),
        ));
    };

    // Three bays that are open towards the camera.
    for (low, high) in [
        ([-5.0, -0.2, -5.0], [5.0, 0.0, 2.5]),
        ([-5.0, 0.0, -5.0], [-4.8, 2.8, 2.5]),
        ([-1.7, 0.0, -5.0], [-1.5, 2.8, 2.5]),
        ([1.5, 0.0, -5.0], [1.7, 2.8, 2.5]),
        ([4.8, 0.0, -5.0], [5.0, 2.8, 2.5]),
        ([-4.8, 0.0, -2.0], [1.5, 2.8, -1.8]),
        ([1.7, 0.0, -5.0], [4.8, 2.8, -4.8]),
    ] {
        let [low, high] = [low, high].map(Vec3::from);
        let [x, y, z] = (0.5 * (low + high)).to_array();
        let plaster = Color::srgb(0.8, 0.79, 0.76).into();
        add(Cuboid::from_size(high - low).into(), plaster, x, y, z);
    }
    // A rug of two colours under the light.
    let rug = StandardMaterial {
        base_color_texture: Some(images.add(paint(|at| {
            [[200, 30, 20, 255], [20, 60, 200, 255]][usize::from(at.x > 0.5)]
        }))),
        ..default()
    };
    let flat = Plane3d::default().mesh().size(2.9, 3.6).into();
    add(flat, rug, -3.25, 0.02, 0.2);
    // A sign: all of it is one quad, and its map glows in two rings.
    let glow = paint(|at| {
        let is_left = at.x < 0.5;
        let center = Vec2::new(if is_left { 0.25 } else { 0.75 }, 0.5);
        let distance = ((at - center) * Vec2::new(2.0, 1.0)).length();
        let color = [[60, 230, 255, 255], [255, 120, 30, 255]][usize::from(is_left)];
        [[0, 0, 0, 255], color][usize::from((0.25..0.45).contains(&distance))]
    });
    let sign = StandardMaterial {
        base_color: Color::srgb(0.1, 0.1, 0.1),
        emissive: LinearRgba::rgb(40.0, 40.0, 40.0),
        emissive_texture: Some(images.add(glow)),
        ..default()
    };
    add(Rectangle::new(2.8, 1.4).into(), sign, 0.0, 1.3, -1.78);
    // A fence, whose gaps are in the alpha of its texture, before a tube that emits.
    let bars = paint(|at| {
        let is_bar = (4.0 * at.x + 0.25).fract() < 0.5;
        [90, 70, 50, if is_bar { 255 } else { 0 }]
    });
    let fence = StandardMaterial {
        base_color_texture: Some(images.add(bars)),
        alpha_mode: AlphaMode::Mask(0.5),
        cull_mode: None,
        double_sided: true,
        ..default()
    };
    add(Rectangle::new(3.1, 2.8).into(), fence, 3.25, 1.4, -1.0);
    let tube = StandardMaterial {
        emissive: LinearRgba::rgb(400.0, 360.0, 300.0),
        ..default()
    };
    add(Cuboid::new(0.2, 2.0, 0.2).into(), tube, 3.25, 1.4, -2.6);
}

fn switch(
    keys: Res<ButtonInput<KeyCode>>,
    mut visibility: Single<&mut Visibility, With<VoxelGiVolume>>,
    mut caption: Single<&mut Text, With<common::Caption>>,
) {
    if keys.just_pressed(KeyCode::Space) {
        visibility.toggle_visible_hidden();
    }
    let is_on = **visibility != Visibility::Hidden;
    caption.0 = format!(
        "indirect light: {} (Space)",
        ["off", "on"][usize::from(is_on)]
    );
}

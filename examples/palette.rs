//! A street whose meshes all have one material: their colours and their emission are cells of one palette texture, as in
//! most low-poly games. Light takes each surface's own colour.
//!
//! Space: light on and off. C: the colours of surfaces, or gray for all.

mod common;

use bevy::{
    asset::RenderAssetUsages,
    camera::Exposure,
    camera_controller::free_camera::FreeCamera,
    mesh::VertexAttributeValues,
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};
use bevy_voxel_gi::{Sky, VoxelAlbedo, VoxelGiPlugin, VoxelGiSettings, VoxelGiVolume};

fn main() -> AppExit {
    App::new()
        .add_plugins((common::plugins(), VoxelGiPlugin))
        .insert_resource(GlobalAmbientLight::NONE)
        .insert_resource(ClearColor(Color::srgb(0.05, 0.07, 0.14)))
        .add_systems(Startup, spawn)
        .add_systems(Update, (switch, describe))
        .run()
}

/// Cells of the palette: base colour and emission.
const CELLS: [([u8; 3], [u8; 3]); 6] = [
    ([200, 196, 188], [0, 0, 0]),
    ([190, 44, 30], [0, 0, 0]),
    ([40, 140, 60], [0, 0, 0]),
    ([60, 64, 72], [0, 0, 0]),
    ([255, 170, 70], [255, 150, 50]),
    ([90, 170, 255], [60, 150, 255]),
];
const STONE: usize = 0;
const RED: usize = 1;
const GREEN: usize = 2;
const ASPHALT: usize = 3;
const LIGHT: usize = 4;
const SIGN: usize = 5;

/// A row of cells of 4 x 4 pixels. An image may be compressed, or only on the GPU: light is the same.
fn row(color: impl Fn(usize) -> [u8; 3]) -> Image {
    let width = 4 * CELLS.len();
    let texels = (0..4 * width).flat_map(|i| {
        let [r, g, b] = color(i % width / 4);
        [r, g, b, 255]
    });
    let size = Extent3d {
        width: width as u32,
        height: 4,
        depth_or_array_layers: 1,
    };
    let format = TextureFormat::Rgba8UnormSrgb;
    let usage = RenderAssetUsages::RENDER_WORLD;
    Image::new(size, TextureDimension::D2, texels.collect(), format, usage)
}

/// A box of one cell's colour: all of its coordinates are in the middle of the cell.
fn block(size: [f32; 3], cell: usize) -> Mesh {
    let mut mesh = Mesh::from(Cuboid::from_size(size.into()));
    let middle = [(cell as f32 + 0.5) / CELLS.len() as f32, 0.5];
    let uvs = vec![middle; mesh.count_vertices()];
    mesh.insert_attribute(Mesh::ATTRIBUTE_UV_0, VertexAttributeValues::Float32x2(uvs));
    mesh
}

fn spawn(
    mut commands: Commands,
    mut images: ResMut<Assets<Image>>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    commands.spawn((
        VoxelGiVolume {
            sky: Some(Sky::uniform(LinearRgba::rgb(1.0, 1.5, 3.0))),
            ..VoxelGiVolume::fixed(16.0)
        },
        Transform::from_xyz(0.0, 3.0, 0.0),
    ));
    commands.insert_resource(VoxelGiSettings {
        resolution: 64,
        ..default()
    });
    commands.spawn((
        Camera3d::default(),
        FreeCamera::default(),
        Exposure { ev100: 4.5 },
        Transform::from_xyz(0.4, 1.7, 7.0).looking_at(Vec3::new(-0.2, 1.9, 0.0), Vec3::Y),
    ));
    let material = materials.add(StandardMaterial {
        base_color_texture: Some(images.add(row(|cell| CELLS[cell].0))),
        emissive: LinearRgba::rgb(350.0, 350.0, 350.0),
        emissive_texture: Some(images.add(row(|cell| CELLS[cell].1))),
        perceptual_roughness: 0.9,
        ..default()
    });
    for (center, size, cell) in [
        ([0.0, -0.25, 0.0], [14.0, 0.5, 15.0], ASPHALT),
        ([-3.5, 3.0, -1.0], [2.0, 6.0, 12.0], RED),
        ([3.5, 3.0, -1.0], [2.0, 6.0, 12.0], GREEN),
        ([0.0, 3.0, -7.0], [9.0, 6.0, 0.5], STONE),
        ([-0.6, 0.4, -3.5], [1.2, 0.8, 1.2], STONE),
        ([1.2, 0.7, -1.6], [0.7, 1.4, 0.7], STONE),
        // Emissive surfaces: lights on both walls, and a sign at the end of the street.
        ([-2.4, 2.2, 1.0], [0.2, 0.3, 1.6], LIGHT),
        ([2.4, 2.2, -3.0], [0.2, 0.3, 1.6], LIGHT),
        ([0.0, 3.6, -6.6], [2.4, 0.7, 0.2], SIGN),
    ] {
        commands.spawn((
            Mesh3d(meshes.add(block(size, cell))),
            MeshMaterial3d(material.clone()),
            Transform::from_translation(center.into()),
        ));
    }
}

fn switch(
    keys: Res<ButtonInput<KeyCode>>,
    mut settings: ResMut<VoxelGiSettings>,
    mut visibility: Single<&mut Visibility, With<VoxelGiVolume>>,
) {
    if keys.just_pressed(KeyCode::Space) {
        visibility.toggle_visible_hidden();
    }
    if keys.just_pressed(KeyCode::KeyC) {
        settings.albedo = match settings.albedo {
            VoxelAlbedo::Neutral => VoxelAlbedo::Material,
            _ => VoxelAlbedo::Neutral,
        };
    }
}

fn describe(
    mut caption: Single<&mut Text, With<common::Caption>>,
    visibility: Single<&Visibility, With<VoxelGiVolume>>,
    settings: Res<VoxelGiSettings>,
) {
    let is_off = **visibility == Visibility::Hidden;
    caption.0 = format!(
        "indirect light: {} (Space)\ncolours: {:?} (C)",
        if is_off { "off" } else { "on" },
        settings.albedo,
    );
}

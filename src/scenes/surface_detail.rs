//! Bevy's own normal maps, as the simplest example of a scene.
//!
//! It shows no plugin of this repository. It is there to try out the runner, and to copy when a
//! new scene begins: knobs of every kind, shared and one-sided entities, a memory figure.

use bevy::{
    asset::RenderAssetUsages,
    image::{ImageAddressMode, ImageSampler, ImageSamplerDescriptor},
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};
use image::{DynamicImage, RgbImage};

use crate::{
    content::{self, Material},
    runner::{Knob, Knobs, MemoryFigures, Scene, Side},
};

/// Side of the textures in pixels.
const TEXTURE_SIZE: u32 = 256;

/// A cube without ("before") and with ("after") a normal map.
pub struct SurfaceDetail;

impl Scene for SurfaceDetail {
    fn name(&self) -> &'static str {
        "surface_detail"
    }

    fn plugin(&self) -> &'static str {
        "bevy_pbr"
    }

    fn description(&self) -> &'static str {
        "A cube without and with a normal map"
    }

    fn knobs(&self) -> Vec<Knob> {
        vec![
            Knob::choice(
                "material",
                "what the cube is made of",
                0,
                &["bricks", "wood", "rock"],
            ),
            Knob::float("roughness", "perceptual roughness", 0.6, 0.1..=1.0, ""),
            Knob::float(
                "light_angle",
                "direction of the light",
                60.0,
                0.0..=360.0,
                "degrees",
            ),
            Knob::integer("seed", "another cube of the same kind", 1, 0..=99, ""),
            Knob::toggle("spin", "turns the cube", false),
        ]
    }

    fn view(&self) -> Transform {
        Transform::from_xyz(0.9, 1.0, 1.6).looking_at(Vec3::ZERO, Vec3::Y)
    }

    fn build(&self, app: &mut App) {
        app.add_systems(Startup, spawn)
            .add_systems(Update, (apply_knobs, spin));
    }
}

#[derive(Component)]
struct Cube;

fn spawn(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>) -> Result {
    let mesh = Mesh::from(Cuboid::default()).with_generated_tangents()?;
    let mesh = meshes.add(mesh);
    for side in Side::BOTH {
        commands.spawn((Cube, side, side.layers(), Mesh3d(mesh.clone())));
    }
    commands.spawn((DirectionalLight::default(), Transform::default()));
    Ok(())
}

fn apply_knobs(
    mut commands: Commands,
    knobs: Res<Knobs>,
    mut memory: ResMut<MemoryFigures>,
    mut images: ResMut<Assets<Image>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    cubes: Query<(Entity, &Side), With<Cube>>,
    mut lights: Query<&mut Transform, With<DirectionalLight>>,
) {
    if !knobs.is_changed() {
        return;
    }
    let generate = match knobs.choice("material") {
        "wood" => content::wood,
        "rock" => content::noise,
        _ => content::bricks,
    };
    let seed = knobs.integer("seed").into();
    let Material { color, normal, .. } = generate(TEXTURE_SIZE, TEXTURE_SIZE, seed);
    let color = images.add(texture(color, true));
    let normal = images.add(texture(normal, false));
    for (entity, side) in &cubes {
        let material = materials.add(StandardMaterial {
            base_color_texture: Some(color.clone()),
            normal_map_texture: (*side == Side::After).then(|| normal.clone()),
            perceptual_roughness: knobs.float("roughness"),
            ..default()
        });
        commands.entity(entity).insert(MeshMaterial3d(material));
    }
    let (sin, cos) = knobs.float("light_angle").to_radians().sin_cos();
    for mut transform in &mut lights {
        *transform = Transform::from_xyz(sin, 0.7, cos).looking_at(Vec3::ZERO, Vec3::Y);
    }
    let bytes = u64::from(4 * TEXTURE_SIZE * TEXTURE_SIZE);
    memory.0.insert("textures before".into(), bytes);
    memory.0.insert("textures after".into(), 2 * bytes);
}

fn spin(time: Res<Time>, knobs: Res<Knobs>, mut cubes: Query<&mut Transform, With<Cube>>) {
    if knobs.toggle("spin") {
        for mut transform in &mut cubes {
            transform.rotate_y(time.delta_secs());
        }
    }
}

/// A repeating texture; colours are sRGB encoded, normals are not.
fn texture(image: RgbImage, is_srgb: bool) -> Image {
    let size = Extent3d {
        width: image.width(),
        height: image.height(),
        depth_or_array_layers: 1,
    };
    let mut texture = Image::new(
        size,
        TextureDimension::D2,
        DynamicImage::from(image).into_rgba8().into_raw(),
        if is_srgb {
            TextureFormat::Rgba8UnormSrgb
        } else {
            TextureFormat::Rgba8Unorm
        },
        RenderAssetUsages::RENDER_WORLD,
    );
    texture.sampler = ImageSampler::Descriptor(ImageSamplerDescriptor {
        address_mode_u: ImageAddressMode::Repeat,
        address_mode_v: ImageAddressMode::Repeat,
        ..ImageSamplerDescriptor::linear()
    });
    texture
}

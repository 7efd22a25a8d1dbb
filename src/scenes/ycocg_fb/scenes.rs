//! The scenes that the frame buffer is measured on.
//!
//! | scene | what it is hard for |
//! | --- | --- |
//! | `lit` | nothing in particular: textures, lights and shadows as in a game |
//! | `equal_luminance_edges` | filters that look for edges in luminance: there are none |
//! | `thin_lines` | filters that need a neighbour of the same surface |
//! | `foliage` | all filters: detail as fine as a pixel, in luminance and chrominance |
//! | `hdr_edge` | filters that compare absolute values: 10,000 beside 0 |
//! | `dark` | filters that compare absolute values, and formats: 0.01 on average |

use std::f32::consts::{FRAC_PI_2, TAU};

use bevy::{
    asset::RenderAssetUsages,
    camera::{Exposure, Hdr, ScalingMode},
    color::Hsva,
    core_pipeline::tonemapping::{DebandDither, Tonemapping},
    ecs::entity::EntityHashSet,
    light::{CascadeShadowConfigBuilder, GlobalAmbientLight},
    math::Affine2,
    mesh::PrimitiveTopology,
    prelude::*,
};
use image::{DynamicImage, RgbImage};

use crate::{
    content::{self, mipped_texture},
    headless::LabTarget,
};

pub const SCENES: [TestScene; 6] = [
    LIT,
    EQUAL_LUMINANCE_EDGES,
    THIN_LINES,
    FOLIAGE,
    HDR_EDGE,
    DARK,
];

/// A scene, without its camera.
#[derive(Clone, Copy, Debug)]
pub struct TestScene {
    /// Its name in the records.
    pub name: &'static str,
    pub description: &'static str,
    view: View,
    spawn: fn(&mut World, UVec2),
}

/// Where the camera stands.
#[derive(Clone, Copy, Debug)]
enum View {
    /// At a point, looking at another.
    Perspective { eye: Vec3, target: Vec3 },
    /// One unit is one pixel, the origin in the middle.
    Pixels,
}

impl TestScene {
    /// Spawns the scene and a camera with `Hdr` and no multisampling, which draws to the app's
    /// [`LabTarget`] of `size` pixels.
    pub fn spawn(&self, world: &mut World, size: UVec2, tonemapping: Tonemapping) -> Entity {
        (self.spawn)(world, size);
        let (projection, pose) = self.camera(size);
        let target = world.resource::<LabTarget>().0.clone();
        world
            .spawn((
                Camera3d::default(),
                target,
                Hdr,
                Msaa::Off,
                tonemapping,
                DebandDither::Disabled,
                Exposure::default(),
                projection,
                pose,
            ))
            .id()
    }

    /// Spawns the scene without a camera; gives what it consists of. The colour that cameras clear
    /// to and the ambient light are those of the scene, or Bevy's.
    pub fn spawn_content(&self, world: &mut World, size: UVec2) -> Vec<Entity> {
        type Content = Or<(With<Mesh3d>, With<DirectionalLight>)>;
        let mut query = world.query_filtered::<Entity, Content>();
        let others: EntityHashSet = query.iter(world).collect();
        world.insert_resource(ClearColor::default());
        world.insert_resource(GlobalAmbientLight::default());
        (self.spawn)(world, size);
        let content = query.iter(world);
        content.filter(|entity| !others.contains(entity)).collect()
    }

    /// Projection and pose of a camera that draws pictures of `size` pixels.
    pub fn camera(&self, size: UVec2) -> (Projection, Transform) {
        match self.view {
            View::Perspective { eye, target } => (
                Projection::from(PerspectiveProjection::default()),
                Transform::from_translation(eye).looking_at(target, Vec3::Y),
            ),
            View::Pixels => (
                Projection::from(OrthographicProjection {
                    scaling_mode: ScalingMode::Fixed {
                        width: size.x as f32,
                        height: size.y as f32,
                    },
                    ..OrthographicProjection::default_3d()
                }),
                Transform::from_xyz(0.0, 0.0, 10.0),
            ),
        }
    }

    /// Whether a unit is a pixel, so that the content depends on the size of the picture.
    pub fn is_in_pixels(&self) -> bool {
        matches!(self.view, View::Pixels)
    }
}

/// A courtyard with coloured things in it.
const LIT: TestScene = TestScene {
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
const DARK: TestScene = TestScene {
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
const FOLIAGE: TestScene = TestScene {
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

/// Saturated colours of the same luminance side by side.
const EQUAL_LUMINANCE_EDGES: TestScene = TestScene {
    name: "equal_luminance_edges",
    description: "discs, bars and triangles of saturated colours, all of luminance 0.2",
    view: View::Pixels,
    spawn: spawn_equal_luminance,
};

/// Luminance of everything, `R / 4 + G / 2 + B / 4`.
const LUMINANCE: f32 = 0.2;

/// Colours up to their luminance, which is made equal.
const EQUAL_COLORS: [Vec3; 8] = [
    Vec3::new(1.0, 0.0, 0.0),
    Vec3::new(0.0, 1.0, 0.0),
    Vec3::new(0.0, 0.0, 1.0),
    Vec3::new(1.0, 1.0, 0.0),
    Vec3::new(0.0, 1.0, 1.0),
    Vec3::new(1.0, 0.0, 1.0),
    Vec3::new(1.0, 0.4, 0.1),
    Vec3::new(1.0, 1.0, 1.0),
];

fn equal_color(index: usize) -> LinearRgba {
    let color = EQUAL_COLORS[index % EQUAL_COLORS.len()];
    let color = color * (LUMINANCE / color.dot(Vec3::new(0.25, 0.5, 0.25)));
    LinearRgba::rgb(color.x, color.y, color.z)
}

fn spawn_equal_luminance(world: &mut World, size: UVec2) {
    let half = size.as_vec2() / 2.0;
    let back = Rectangle::from_size(size.as_vec2());
    add(
        world,
        back,
        flat(equal_color(7)),
        Transform::from_xyz(0.0, 0.0, -1.0),
    );
    let mut random = Random::new(3);
    // Sparse enough that edges, not corners, are what is measured.
    let count = size.x * size.y / 1400;
    for i in 0..count as usize {
        let center = Vec2::new(
            random.between(-half.x, half.x),
            random.between(-half.y, half.y),
        );
        let radius = random.between(0.03, 0.12) * size.min_element() as f32;
        let turn = random.between(0.0, TAU);
        let corner = |angle: f32| center + Vec2::from_angle(turn + angle) * radius;
        let corners = match i % 3 {
            0 => [corner(0.0), corner(TAU / 3.0), corner(TAU * 2.0 / 3.0)].to_vec(),
            1 => line(corner(0.0), corner(TAU / 2.0), radius * 0.5).to_vec(),
            _ => disc(&corner, center),
        };
        let pose = Transform::from_xyz(0.0, 0.0, i as f32 / count as f32);
        add(
            world,
            triangles(&corners),
            flat(equal_color(i * 5 + i / 8)),
            pose,
        );
    }
}

fn disc(corner: &impl Fn(f32) -> Vec2, center: Vec2) -> Vec<Vec2> {
    const SLICES: usize = 24;
    let angle = |i: usize| TAU * i as f32 / SLICES as f32;
    (0..SLICES)
        .flat_map(|i| [center, corner(angle(i)), corner(angle(i + 1))])
        .collect()
}

/// Lights of a luminance of 10,000 beside black.
const HDR_EDGE: TestScene = TestScene {
    name: "hdr_edge",
    description: "tubes of light of up to 10,000 in warm and cold colours before black and dusk",
    view: View::Pixels,
    spawn: spawn_hdr_edge,
};

/// Colours of the lights, the largest channel 1.
const LIGHT_COLORS: [[f32; 3]; 5] = [
    [1.0, 0.45, 0.12],
    [0.35, 0.6, 1.0],
    [1.0, 0.08, 0.05],
    [1.0, 0.95, 0.8],
    [0.1, 1.0, 0.35],
];

fn spawn_hdr_edge(world: &mut World, size: UVec2) {
    world.insert_resource(ClearColor(Color::BLACK));
    let size = size.as_vec2();
    // The lower half is dusk: a dim wall that is not grey.
    let wall = flat(LinearRgba::rgb(0.04, 0.06, 0.11));
    let pose = Transform::from_xyz(0.0, -size.y / 4.0, -1.0);
    add(world, Rectangle::new(size.x, size.y / 2.0), wall, pose);
    let mut random = Random::new(23);
    for i in 0..10 {
        let [r, g, b] = LIGHT_COLORS[i % LIGHT_COLORS.len()];
        // From what a display can just show to what blinds.
        let intensity = [1e4, 3.0, 30.0][i % 3];
        let color = LinearRgba::rgb(r * intensity, g * intensity, b * intensity);
        let center = Vec2::new(
            ((i as f32 + 0.5) / 10.0 - 0.5) * size.x,
            random.between(-0.2, 0.2) * size.y,
        );
        let half = Vec2::from_angle(random.between(0.6, 2.5)) * random.between(0.1, 0.25) * size.y;
        let tube = line(center - half, center + half, random.between(1.0, 9.0));
        let pose = Transform::from_xyz(0.0, 0.0, i as f32 / 10.0);
        add(world, triangles(&tube), flat(color), pose);
    }
}

/// Coloured lines of one pixel.
const THIN_LINES: TestScene = TestScene {
    name: "thin_lines",
    description: "one-pixel lines of all hues and directions on bright and dark ground",
    view: View::Pixels,
    spawn: spawn_thin_lines,
};

fn spawn_thin_lines(world: &mut World, size: UVec2) {
    let size = size.as_vec2();
    let half = size / 2.0;
    // Left half dark, right half bright, as the filters see a line against each differently.
    for (side, shade) in [(-0.5, 0.03), (0.5, 0.6)] {
        let ground = Rectangle::new(half.x, size.y);
        let pose = Transform::from_xyz(side * half.x, 0.0, -1.0);
        add(
            world,
            ground,
            flat(LinearRgba::rgb(shade, shade, shade)),
            pose,
        );
    }
    let mut random = Random::new(11);
    let count = (size.y / 6.0) as usize;
    for i in 0..count {
        let hue = 360.0 * i as f32 / count as f32;
        let color = LinearRgba::from(Hsva::new(hue, 0.9, 0.9, 1.0));
        let level = -half.y + (i as f32 + 0.5) * size.y / count as f32;
        // Every third horizontal, every third vertical: the exact axes are the hardest.
        let (from, to) = match i % 3 {
            0 => (
                Vec2::new(-half.x, level.floor() + 0.5),
                Vec2::new(half.x, level.floor() + 0.5),
            ),
            1 => {
                // In another order than that of the hues, so that neighbours differ.
                let x = -half.x + (i * 37 % count) as f32 * size.x / count as f32;
                let x = x.floor() + 0.5;
                (Vec2::new(x, -half.y), Vec2::new(x, half.y))
            }
            _ => (
                Vec2::new(-half.x, random.between(-half.y, half.y)),
                Vec2::new(half.x, random.between(-half.y, half.y)),
            ),
        };
        let pose = Transform::from_xyz(0.0, 0.0, i as f32 / count as f32);
        add(world, triangles(&line(from, to, 1.0)), flat(color), pose);
    }
}

const SEED: u64 = 7;

pub fn add(world: &mut World, mesh: impl Into<Mesh>, material: StandardMaterial, pose: Transform) {
    let mesh = world.add_asset(mesh);
    let material = world.add_asset::<StandardMaterial>(material);
    world.spawn((Mesh3d(mesh), MeshMaterial3d(material), pose));
}

fn textured(world: &mut World, source: content::Material) -> StandardMaterial {
    let mut add = |image: RgbImage, is_srgb| {
        let image = DynamicImage::from(image).into_rgba8();
        Some(world.add_asset(mipped_texture(&image, is_srgb)))
    };
    StandardMaterial {
        base_color_texture: add(source.color, true),
        normal_map_texture: add(source.normal, false),
        ..default()
    }
}

/// A material whose pixels have exactly this colour, scene-linear.
fn flat(color: LinearRgba) -> StandardMaterial {
    StandardMaterial {
        base_color: color.into(),
        unlit: true,
        double_sided: true,
        cull_mode: None,
        ..default()
    }
}

/// Triangles in the plane of the screen, three corners each.
fn triangles(corners: &[Vec2]) -> Mesh {
    let positions: Vec<[f32; 3]> = corners.iter().map(|c| [c.x, c.y, 0.0]).collect();
    let normals = vec![[0.0, 0.0, 1.0]; positions.len()];
    let uvs = vec![[0.0, 0.0]; positions.len()];
    Mesh::new(
        PrimitiveTopology::TriangleList,
        RenderAssetUsages::RENDER_WORLD,
    )
    .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
    .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, normals)
    .with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, uvs)
}

/// Corners of a line of `width` pixels.
fn line(from: Vec2, to: Vec2, width: f32) -> [Vec2; 6] {
    let side = (to - from).normalize_or_zero().perp() * (width / 2.0);
    let [a, b, c, d] = [from - side, from + side, to - side, to + side];
    [a, b, c, c, b, d]
}

/// A repeatable sequence of numbers of 0 to 1 (a 64-bit linear congruential generator with Knuth's
/// multiplier; the upper half of its state).
struct Random(u64);

impl Random {
    fn new(seed: u64) -> Self {
        Self(seed)
    }

    fn next(&mut self) -> f32 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1u64 << 24) as f32
    }

    fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.next()
    }
}

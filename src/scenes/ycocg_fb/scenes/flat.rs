//! Scenes of flat shapes, scene-linear, where a unit is a pixel.

use std::f32::consts::TAU;

use bevy::{color::Hsva, prelude::*};

use super::{
    TestScene, View,
    shapes::{Random, add, flat, line, triangles},
};

/// Saturated colours of the same luminance side by side.
pub(super) const EQUAL_LUMINANCE_EDGES: TestScene = TestScene {
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
pub(super) const HDR_EDGE: TestScene = TestScene {
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
pub(super) const THIN_LINES: TestScene = TestScene {
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

//! Saturated colours of the same luminance side by side.

use std::f32::consts::TAU;

use bevy::prelude::*;

use crate::scenes::ycocg_fb::scenes::{
    scene::{TestScene, View},
    shapes::{Random, add, flat, line, triangles},
};

pub(super) const SCENE: TestScene = TestScene {
    name: "equal_luminance_edges",
    description: "discs, bars and triangles of saturated colours, all of luminance 0.2",
    view: View::Pixels,
    spawn,
};

/// Luminance of everything, `R / 4 + G / 2 + B / 4`.
const LUMINANCE: f32 = 0.2;

/// Colours up to their luminance, which is made equal.
const COLORS: [Vec3; 8] = [
    Vec3::new(1.0, 0.0, 0.0),
    Vec3::new(0.0, 1.0, 0.0),
    Vec3::new(0.0, 0.0, 1.0),
    Vec3::new(1.0, 1.0, 0.0),
    Vec3::new(0.0, 1.0, 1.0),
    Vec3::new(1.0, 0.0, 1.0),
    Vec3::new(1.0, 0.4, 0.1),
    Vec3::new(1.0, 1.0, 1.0),
];

fn color(index: usize) -> LinearRgba {
    let color = COLORS[index % COLORS.len()];
    let color = color * (LUMINANCE / color.dot(Vec3::new(0.25, 0.5, 0.25)));
    LinearRgba::rgb(color.x, color.y, color.z)
}

fn spawn(world: &mut World, size: UVec2) {
    let half = size.as_vec2() / 2.0;
    let back = Rectangle::from_size(size.as_vec2());
    add(
        world,
        back,
        flat(color(7)),
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
        add(world, triangles(&corners), flat(color(i * 5 + i / 8)), pose);
    }
}

fn disc(corner: &impl Fn(f32) -> Vec2, center: Vec2) -> Vec<Vec2> {
    const SLICES: usize = 24;
    let angle = |i: usize| TAU * i as f32 / SLICES as f32;
    (0..SLICES)
        .flat_map(|i| [center, corner(angle(i)), corner(angle(i + 1))])
        .collect()
}

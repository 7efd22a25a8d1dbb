//! The statue: a torus knot with dents, on a pedestal.

use std::f32::consts::TAU;

use bevy::math::{Vec2, Vec3};

use crate::meshes::{
    arcade::materials::Materials,
    scene::{SceneMesh, ScenePart},
};

/// The middle of the pedestal's foot.
const POSITION: Vec3 = Vec3::new(-0.9, 0.0, -1.2);
/// Half of the pedestal's width, and its height.
const PEDESTAL: [f32; 2] = [0.45, 0.7];
/// The middle of the knot above the pedestal, and its size.
const KNOT_HEIGHT: f32 = 0.95;
const KNOT_SIZE: f32 = 0.28;
/// Radius of the tube.
const TUBE: f32 = 0.17;

pub(super) fn parts(materials: &Materials, triangles: u32) -> [ScenePart; 2] {
    let [half, height] = PEDESTAL;
    let pedestal = SceneMesh::cuboid(Vec3::new(-half, 0.0, -half), Vec3::new(half, height, half));
    // Eight times as many along the tube as around it.
    let rows = (triangles as f32 / 16.0).sqrt().round().max(3.0) as u32;
    let knot = SceneMesh::grid(8 * rows, rows, surface);
    [
        ScenePart::new(pedestal, &materials.stone, POSITION),
        ScenePart::new(
            knot,
            &materials.marble,
            POSITION + (height + KNOT_HEIGHT) * Vec3::Y,
        ),
    ]
}

/// The middle of the tube: a trefoil that stands upright.
fn curve(t: f32) -> Vec3 {
    let angle = TAU * t;
    let at = Vec3::new(
        angle.sin() + 2.0 * (2.0 * angle).sin(),
        angle.cos() - 2.0 * (2.0 * angle).cos(),
        -(3.0 * angle).sin(),
    );
    KNOT_SIZE * at
}

/// A point of the surface, from coordinates along and around the tube.
fn surface(uv: Vec2) -> Vec3 {
    let (center, step) = (curve(uv.x), 1e-3);
    let tangent = (curve(uv.x + step) - curve(uv.x - step)).normalize();
    // The knot's tangents are never along Z, which so gives a frame that closes.
    let side = tangent.cross(Vec3::Z).normalize();
    let up = side.cross(tangent);
    let (sin, cos) = (TAU * uv.y).sin_cos();
    let dents = 0.12 * (TAU * (40.0 * uv.x + 2.0 * uv.y)).sin()
        + 0.06 * (TAU * (90.0 * uv.x - 5.0 * uv.y)).sin() * (TAU * 7.0 * uv.y).cos();
    center + TUBE * (1.0 + dents) * (cos * side + sin * up)
}

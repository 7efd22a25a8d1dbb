//! Floor, walls, arches, stairs, the door and the sign.

use std::f32::consts::FRAC_PI_2;

use bevy::math::{Quat, Vec2, Vec3};

use crate::meshes::{
    arcade::materials::Materials,
    scene::{SceneMesh, ScenePart},
};

/// Half of the hall's width and length.
const HALF: f32 = 4.0;
const HEIGHT: f32 = 4.8;
/// Thickness of the walls.
const WALL: f32 = 0.4;
/// The middle of the arcade's wall along X.
const ARCADE_X: f32 = 1.8;
/// Number of arches.
const ARCHES: u32 = 3;
/// Radius of an arch, and the height at which it begins.
const RADIUS: f32 = 1.0;
const SPRING: f32 = 2.0;
/// The ends of the doorway along Z, and its height.
const DOORWAY: [f32; 2] = [-1.1, 0.7];
const DOOR_HEIGHT: f32 = 2.5;
const DOOR_THICKNESS: f32 = 0.08;
/// The step of the stairs: its height and its depth.
const RISE: f32 = 0.2;
const TREAD: f32 = 0.32;
const STEPS: u32 = 7;

pub(super) fn parts(materials: &Materials) -> Vec<ScenePart> {
    let span = |low: [f32; 3], high: [f32; 3]| SceneMesh::cuboid(low.into(), high.into());
    let (end, top) = (HALF + WALL, HEIGHT + WALL);
    let mut right = span([HALF, 0.0, -end], [end, HEIGHT, DOORWAY[0]]);
    right.add_box(
        Vec3::new(HALF, 0.0, DOORWAY[1]),
        Vec3::new(end, HEIGHT, end),
    );
    right.add_box(
        Vec3::new(HALF, DOOR_HEIGHT, DOORWAY[0]),
        Vec3::new(end, HEIGHT, DOORWAY[1]),
    );
    let mut back_and_front = span([-HALF, 0.0, -end], [HALF, HEIGHT, -HALF]);
    back_and_front.add_box(Vec3::new(-HALF, 0.0, HALF), Vec3::new(HALF, HEIGHT, end));
    let meshes = [
        (
            span([-end, -WALL, -end], [end, 0.0, end]),
            2.0,
            &materials.tiles,
        ),
        (
            span([-end, HEIGHT, -end], [end, top, end]),
            1.0,
            &materials.plaster,
        ),
        (
            span([-end, 0.0, -end], [-HALF, HEIGHT, end]),
            1.5,
            &materials.bricks,
        ),
        (right, 1.0, &materials.red),
        (back_and_front, 1.0, &materials.plaster),
        (stairs(), 1.0, &materials.planks),
    ];
    let place = |(mesh, metres, material): (SceneMesh, f32, _)| {
        ScenePart::new(mesh.repeated(metres), material, Vec3::ZERO)
    };
    let mut parts: Vec<_> = meshes.into_iter().map(place).collect();
    parts.push(arcade(materials));
    parts
}

/// The wall with the arches, along Z.
fn arcade(materials: &Materials) -> ScenePart {
    let width = 2.0 * HALF / ARCHES as f32;
    let mut mesh = SceneMesh::default();
    for i in 0..ARCHES {
        let mut arch = SceneMesh::default();
        arch.add_arch(width, HEIGHT, WALL, RADIUS, SPRING);
        let shift = (i as f32 + 0.5) * width - HALF;
        mesh.append(arch, Vec3::X * shift);
    }
    ScenePart {
        rotation: Quat::from_rotation_y(FRAC_PI_2),
        ..ScenePart::new(mesh.repeated(1.2), &materials.stone, Vec3::X * ARCADE_X)
    }
}

/// Stairs along the back wall, up to the left.
fn stairs() -> SceneMesh {
    let mut mesh = SceneMesh::default();
    for i in 0..STEPS {
        let x = -HALF + TREAD * (STEPS - i) as f32;
        let low = Vec3::new(-HALF, RISE * i as f32, -HALF);
        mesh.add_box(low, Vec3::new(x, RISE * (i + 1) as f32, -HALF + 1.3));
    }
    mesh
}

/// The closed door. Its origin is its hinge, so that its rotation opens it into the hall.
pub(super) fn door(materials: &Materials) -> ScenePart {
    let width = DOORWAY[1] - DOORWAY[0];
    let mesh = SceneMesh::cuboid(Vec3::ZERO, Vec3::new(DOOR_THICKNESS, DOOR_HEIGHT, width));
    let hinge = Vec3::new(HALF, 0.0, DOORWAY[0]);
    ScenePart::new(mesh.repeated(1.0), &materials.planks, hinge)
}

/// The sign on the left wall: letters that emit light, on a box.
pub(super) fn sign(materials: &Materials) -> [ScenePart; 2] {
    let (center, size) = (Vec3::new(-HALF + 0.12, 2.6, -0.6), Vec2::new(1.8, 0.6));
    let half = 0.5 * Vec3::new(0.24, size.y, size.x);
    let body = SceneMesh::cuboid(-half, half);
    let letters = ScenePart {
        rotation: Quat::from_rotation_y(FRAC_PI_2),
        ..ScenePart::new(
            SceneMesh::card(size),
            &materials.sign,
            center + 0.125 * Vec3::X,
        )
    };
    [ScenePart::new(body, &materials.plaster, center), letters]
}

//! The plant: cards of leaves with holes, in a pot.

use std::f32::consts::TAU;

use bevy::math::{EulerRot, Quat, Vec2, Vec3};

use crate::meshes::{
    arcade::materials::Materials,
    scene::{SceneMesh, ScenePart},
};

/// The middle of the pot's foot.
const POSITION: Vec3 = Vec3::new(0.75, 0.0, 1.1);
/// Radius and height of the pot.
const POT: [f32; 2] = [0.28, 0.45];
/// Number of cards, and the edge of one.
const CARDS: u32 = 28;
const CARD: f32 = 0.55;

pub(super) fn parts(materials: &Materials) -> [ScenePart; 2] {
    let mut leaves = SceneMesh::default();
    for i in 0..CARDS {
        // Golden angles around the stem, from the bottom to the top.
        let (angle, height) = (2.399_963 * i as f32, i as f32 / CARDS as f32);
        let (sin, cos) = angle.sin_cos();
        let radius = 0.32 * (1.0 - 0.6 * height);
        let center = Vec3::new(radius * cos, 0.15 + 0.95 * height, radius * sin);
        let tilt = -0.4 - 0.6 * height;
        let rotation = Quat::from_euler(EulerRot::YXZ, TAU / 4.0 - angle, tilt, angle);
        leaves.append_rotated(SceneMesh::card(Vec2::splat(CARD)), rotation, center);
    }
    let pot = SceneMesh::cylinder(POT[0], POT[1], 24);
    [
        ScenePart::new(pot, &materials.red, POSITION),
        ScenePart::new(leaves, &materials.leaves, POSITION + POT[1] * Vec3::Y),
    ]
}

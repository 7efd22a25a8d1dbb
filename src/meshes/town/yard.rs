//! The ground, the yard with its wall, trees and hedge, and what stands in the street.

use std::f32::consts::TAU;

use bevy::math::{Quat, Rect, Vec2, Vec3};

use crate::meshes::{
    SceneMesh, ScenePart,
    town::{
        Materials, depot,
        house::gable,
        things::{Paint, Painted, chest, leaves, scatter, table},
    },
};

/// Half of the town's width and length.
const HALF: f32 = 40.0;
/// The yard within its walls; the depot is at its end of X.
const YARD: Rect = Rect {
    min: Vec2::new(-21.7, 7.3),
    max: Vec2::new(8.0, 33.0),
};
const WALL: f32 = 0.3;
const HEIGHT: f32 = 2.4;
/// The yard's gate along X.
const GATE: [f32; 2] = [-4.0, -0.5];
/// The positions of trees.
const TREES: [Vec3; 4] = [
    Vec3::new(-13.0, 0.0, 13.5),
    Vec3::new(0.5, 0.0, 27.0),
    Vec3::new(-9.5, 0.0, -8.4),
    Vec3::new(31.0, 0.0, 3.0),
];
const TRUNK: f32 = 2.6;

pub(super) fn parts(materials: &Materials) -> Vec<ScenePart> {
    let mut ground = SceneMesh::default();
    let all = Rect::new(-HALF, -HALF, HALF, HALF);
    ground.add_plate(1, [depot::GROUND, 0.0], all, &[depot::SHAFT, depot::STAIRS]);
    let mut parts = vec![
        ScenePart::new(ground.repeated(3.0), &materials.stone, Vec3::ZERO),
        ScenePart::new(wall().repeated(1.5), &materials.bricks, Vec3::ZERO),
        ScenePart::new(hedge(), &materials.leaves, Vec3::new(-11.0, 0.75, 32.2)),
    ];
    for at in TREES {
        let crown = leaves(120, Vec3::new(1.9, 1.6, 1.9), 1.1);
        let crown_at = at + (TRUNK + 1.3) * Vec3::Y;
        parts.push(ScenePart::new(crown, &materials.leaves, crown_at));
    }
    let painted = [yard_things(), street(), trunks()];
    parts.extend(painted.map(|mesh| materials.painted(mesh)));
    parts
}

fn wall() -> SceneMesh {
    let Rect { min, max } = YARD;
    let mut wall = SceneMesh::default();
    let along_x = Rect::new(min.x - WALL, 0.0, max.x + WALL, HEIGHT);
    let gate = Rect::new(GATE[0], 0.0, GATE[1], HEIGHT);
    wall.add_plate(2, [min.y - WALL, min.y], along_x, &[gate]);
    wall.add_plate(2, [max.y, max.y + WALL], along_x, &[]);
    let along_z = Rect::new(min.y, 0.0, max.y, HEIGHT);
    wall.add_plate(0, [min.x - WALL, min.x], along_z, &[]);
    // Beside the depot.
    let depot = depot::FOOTPRINT;
    let hole = Rect::new(depot.min.y, 0.0, depot.max.y, HEIGHT);
    wall.add_plate(0, [max.x, max.x + WALL], along_z, &[hole]);
    wall
}

/// Cards of leaves in a row along X.
fn hedge() -> SceneMesh {
    let mut hedge = SceneMesh::default();
    for i in 0..10 {
        let x = 1.8 * (i as f32 - 4.5);
        let bush = leaves(36, Vec3::new(1.1, 0.8, 0.55), 0.7);
        hedge.append(bush, Vec3::new(x, 0.05 * (i % 3) as f32, 0.0));
    }
    hedge
}

fn trunks() -> Painted {
    let mut trunks = Painted::default();
    for at in TREES {
        trunks.add_cylinder(Paint::Bark, 0.22, TRUNK + 0.6, at);
        for i in 0..3 {
            let mut branch = SceneMesh::default();
            let turn = Quat::from_rotation_y(2.1 * i as f32) * Quat::from_rotation_z(0.8);
            branch.append_rotated(
                SceneMesh::cylinder(0.08, 1.5, 8),
                turn,
                at + TRUNK * Vec3::Y,
            );
            trunks.add(Paint::Bark, branch);
        }
    }
    trunks
}

fn yard_things() -> Painted {
    let mut things = Painted::default();
    // Lawn on both sides of a path from the gate.
    let (low, high) = (YARD.min, YARD.max);
    things.add_box(
        Paint::Grass,
        [low.x, 0.0, low.y],
        [GATE[0] - 1.0, 0.06, high.y],
    );
    let lawn = [GATE[1] + 0.5, 21.0];
    things.add_box(
        Paint::Grass,
        [lawn[0], 0.0, lawn[1]],
        [high.x - 0.8, 0.06, high.y],
    );
    // A well with a roof.
    let well = Vec3::new(-9.0, 0.06, 20.5);
    for i in 0..8 {
        let turn = TAU * i as f32 / 8.0;
        let mut stone = Painted::default();
        stone.add_box(Paint::Concrete, [-0.44, 0.0, 0.82], [0.44, 0.9, 1.12]);
        things.place(stone, turn, well);
    }
    for x in [-1.3, 1.2] {
        let at = well + x * Vec3::X;
        things.add_box(
            Paint::DarkWood,
            [at.x, 0.06, at.z - 0.05],
            [at.x + 0.1, 2.3, at.z + 0.05],
        );
    }
    let roof = Rect::from_center_half_size(Vec2::new(well.x, well.z), Vec2::new(1.6, 1.2));
    things.add(Paint::Terracotta, gable(roof, 2.3, 0.9));
    // Benches, chests and barrels.
    for (x, z, turn) in [(-15.5, 17.0, 0.5), (-6.8, 28.0, 1.4), (3.5, 24.0, 0.0)] {
        things.place(
            table(Paint::Wood, [1.8, 0.45, 0.45]),
            turn,
            Vec3::new(x, 0.06, z),
        );
    }
    for (i, (x, z)) in [(5.9, 9.2), (6.6, 10.6), (5.3, 16.8), (-19.8, 9.4)]
        .into_iter()
        .enumerate()
    {
        let random = scatter(i as u32 + 20);
        let floor = if x < 0.0 { 0.06 } else { 0.0 };
        things.place(chest(1.0), random.x, Vec3::new(x, floor, z));
        things.place(chest(0.7), random.y, Vec3::new(x + 0.1, floor + 1.0, z));
    }
    for (i, paint) in [Paint::Navy, Paint::Red, Paint::Yellow]
        .into_iter()
        .enumerate()
    {
        things.add_cylinder(
            paint,
            0.3,
            0.9,
            Vec3::new(7.3, 0.0, 16.0 + 0.7 * i as f32 - 0.6),
        );
    }
    // A shed in the corner.
    let shed = Rect::new(-21.5, 27.5, -17.5, 31.0);
    let door = Rect::new(28.5, 0.06, 29.5, 2.0);
    for z in [shed.min.y, shed.max.y - 0.2] {
        let outline = Rect::new(shed.min.x, 0.06, shed.max.x, 2.3);
        things.add_plate(Paint::Ochre, 2, [z, z + 0.2], outline, &[]);
    }
    let outline = Rect::new(shed.min.y + 0.2, 0.06, shed.max.y - 0.2, 2.3);
    things.add_plate(
        Paint::Ochre,
        0,
        [shed.min.x, shed.min.x + 0.2],
        outline,
        &[],
    );
    things.add_plate(
        Paint::Ochre,
        0,
        [shed.max.x - 0.2, shed.max.x],
        outline,
        &[door],
    );
    things.add(Paint::Slate, gable(shed.inflate(0.1), 2.3, 1.0));
    things
}

fn street() -> Painted {
    let mut street = Painted::default();
    // The road between two kerbs, with a line of dashes.
    street.add_box(Paint::Asphalt, [-HALF, 0.0, -4.5], [HALF, 0.02, 4.0]);
    for z in [-4.7, 4.0] {
        street.add_box(Paint::Concrete, [-HALF, 0.0, z], [HALF, 0.15, z + 0.2]);
    }
    for i in 0..16 {
        let x = -HALF + 1.5 + 5.0 * i as f32;
        street.add_box(Paint::White, [x, 0.02, -0.35], [x + 2.0, 0.03, -0.15]);
    }
    // Stalls of a market.
    for (i, paint) in [Paint::Red, Paint::Yellow, Paint::Teal, Paint::Purple]
        .into_iter()
        .enumerate()
    {
        let mut stall = table(Paint::Wood, [2.6, 0.9, 1.2]);
        for (x, z) in [(-1.3, -0.7), (1.2, -0.7), (-1.3, 0.6), (1.2, 0.6)] {
            stall.add_box(Paint::DarkWood, [x, 0.0, z], [x + 0.1, 2.3, z + 0.1]);
        }
        stall.add_box(paint, [-1.6, 2.3, -1.0], [1.6, 2.4, 1.0]);
        for k in 0..6 {
            let at = Vec3::new(-1.0 + 0.4 * k as f32, 0.9, 0.2 * scatter(k).x);
            let fruit = [Paint::Orange, Paint::Moss, Paint::Red][(i + k as usize) % 3];
            stall.add_cylinder(fruit, 0.15, 0.2, at);
        }
        street.place(stall, 0.0, Vec3::new(11.0 + 4.2 * i as f32, 0.0, 5.6));
    }
    // A cart, and chests at the houses.
    street.place(cart(), 0.5, Vec3::new(-10.0, 0.02, 1.8));
    for (i, (x, z)) in [(-12.3, -9.5), (8.8, -14.5), (22.6, -13.0), (-30.0, -24.5)]
        .into_iter()
        .enumerate()
    {
        let random = scatter(i as u32 + 40);
        street.place(chest(0.9), random.x, Vec3::new(x, 0.0, z));
        street.add_cylinder(Paint::Navy, 0.3, 0.9, Vec3::new(x + 0.2, 0.0, z + 1.0));
    }
    // Fences between gardens.
    for (x, from, to) in [
        (-11.0, -23.0, -36.0),
        (13.5, -26.0, -38.0),
        (-26.5, -24.0, -38.0),
    ] {
        let count = ((from - to) / 0.5) as u32;
        for i in 0..count {
            let z = from - 0.5 * i as f32;
            street.add_box(Paint::White, [x, 0.0, z - 0.14], [x + 0.04, 1.1, z]);
        }
        for y in [0.3, 0.8] {
            street.add_box(Paint::White, [x + 0.04, y, to], [x + 0.08, y + 0.08, from]);
        }
    }
    // Street lights, which are off.
    for x in [-30.0, -16.0, -2.0, 12.0, 26.0] {
        street.add_cylinder(Paint::Coal, 0.08, 4.2, Vec3::new(x, 0.0, 4.6));
        street.add_box(Paint::Coal, [x - 0.2, 4.2, 4.4], [x + 0.2, 4.6, 4.8]);
    }
    street
}

fn cart() -> Painted {
    let mut cart = Painted::default();
    cart.add_box(Paint::DarkWood, [-1.2, 0.6, -0.7], [1.2, 0.7, 0.7]);
    for z in [-0.7, 0.64] {
        cart.add_box(Paint::Wood, [-1.2, 0.7, z], [1.2, 1.1, z + 0.06]);
    }
    for (x, z) in [(-0.7, -0.82), (0.7, -0.82), (-0.7, 0.72), (0.7, 0.72)] {
        cart.add_box(Paint::Coal, [x - 0.35, 0.0, z], [x + 0.35, 0.58, z + 0.1]);
    }
    cart.place(chest(0.6), 0.2, Vec3::new(-0.5, 0.7, 0.0));
    cart
}

//! The depot: a hall with skylight and gate, a sealed corridor with a store, offices, and a cellar that stairs and a
//! lift lead to.

use std::f32::consts::{FRAC_PI_2, TAU};

use bevy::math::{Quat, Rect, Vec2, Vec3};

use crate::meshes::{
    SceneMesh, ScenePart,
    town::{
        Materials, TownState, sign,
        things::{Paint, Painted, chair, chest, scatter, shelf, table},
    },
};

/// Outer corners, X and Z.
pub(super) const FOOTPRINT: Rect = rect(8.0, 8.0, 34.0, 30.0);
/// Height under the roof, and under the ceilings of corridor and offices.
const HEIGHT: f32 = 5.5;
const LOW: f32 = 2.8;
/// Thickness of outer walls, and of walls between rooms.
const WALL: f32 = 0.3;
const THIN: f32 = 0.25;
/// Top of the floors.
const FLOOR: f32 = 0.05;
/// The hall, the corridor, the offices and the store within the walls.
const HALL: Rect = rect(8.3, 8.3, 33.7, 17.2);
const CORRIDOR: Rect = rect(8.3, 17.5, 33.7, 20.0);
const OFFICES: Rect = rect(8.3, 20.3, 33.7, 29.7);
const STORE: Rect = rect(28.25, 20.3, 33.7, 24.85);
/// The doorway from the yard to the corridor along Z, and its height.
const DOORWAY: [f32; 2] = [18.1, 19.3];
const DOOR_HEIGHT: f32 = 2.2;
/// Holes of the ground: the shaft of the lift and the stairs.
pub(super) const SHAFT: Rect = rect(25.5, 11.0, 28.5, 14.0);
pub(super) const STAIRS: Rect = rect(14.8, 10.0, 19.2, 11.5);
/// The cellar within its walls; its floor and its ceiling, the ground's lower side.
const CELLAR: Rect = rect(20.0, 9.0, 33.0, 20.0);
const CELLAR_FLOOR: f32 = -3.2;
pub(super) const GROUND: f32 = -0.3;
const SKYLIGHT: Rect = rect(28.3, 12.8, 32.3, 16.8);

const fn rect(x: f32, z: f32, to_x: f32, to_z: f32) -> Rect {
    Rect {
        min: Vec2::new(x, z),
        max: Vec2::new(to_x, to_z),
    }
}

pub(super) fn parts(materials: &Materials) -> Vec<ScenePart> {
    let mut planks = SceneMesh::default();
    let offices = Rect {
        max: Vec2::new(28.0, 29.7),
        ..OFFICES
    };
    planks.add_plate(1, [0.0, FLOOR], offices, &[]);
    let mut parts = vec![
        ScenePart::new(outer_walls().repeated(1.5), &materials.bricks, Vec3::ZERO),
        ScenePart::new(planks.repeated(1.2), &materials.planks, Vec3::ZERO),
    ];
    let painted = [
        inside(),
        roof(),
        cellar(),
        hall_things(),
        cellar_things(),
        office_things(),
        corridor_things(),
    ];
    parts.extend(painted.map(|mesh| materials.painted(mesh)));
    parts.extend(sign(
        materials.depot.clone(),
        &materials.palette,
        Vec3::new(FOOTPRINT.min.x, 3.9, 13.5),
        -FRAC_PI_2,
        Vec2::new(3.2, 0.8),
    ));
    parts.extend(sign(
        materials.exit.clone(),
        &materials.palette,
        Vec3::new(CORRIDOR.min.x, 2.42, 18.7),
        FRAC_PI_2,
        Vec2::new(0.9, 0.3),
    ));
    parts
}

fn outer_walls() -> SceneMesh {
    let Rect { min, max } = FOOTPRINT;
    let mut walls = SceneMesh::default();
    let along_z = Rect::new(min.y + WALL, 0.0, max.y - WALL, HEIGHT);
    let gate = Rect::new(12.0, 0.0, 15.0, 3.2);
    let door = Rect::new(DOORWAY[0], 0.0, DOORWAY[1], DOOR_HEIGHT);
    let window = |from: f32, to: f32| Rect::new(from, 0.9, to, 2.2);
    walls.add_plate(
        0,
        [min.x, min.x + WALL],
        along_z,
        &[gate, door, window(23.0, 25.0)],
    );
    walls.add_plate(0, [max.x - WALL, max.x], along_z, &[window(26.5, 28.0)]);
    let along_x = Rect::new(min.x, 0.0, max.x, HEIGHT);
    let high = [11.0, 16.0, 21.0, 26.0].map(|x| Rect::new(x, 3.0, x + 2.4, 4.4));
    walls.add_plate(2, [min.y, min.y + WALL], along_x, &high);
    let mut low = [10.0, 15.0, 20.0, 24.5, 30.0]
        .map(|x| window(x, x + 1.6))
        .to_vec();
    low.push(Rect::new(16.8, 0.0, 17.8, DOOR_HEIGHT));
    walls.add_plate(2, [max.y - WALL, max.y], along_x, &low);
    walls
}

/// Walls, ceilings and floors between the rooms.
fn inside() -> Painted {
    let mut inside = Painted::default();
    let along = |height| Rect::new(CORRIDOR.min.x, 0.0, CORRIDOR.max.x, height);
    let store_door = Rect::new(29.4, 0.0, 30.6, DOOR_HEIGHT);
    let (low, high) = (CORRIDOR.min.y, CORRIDOR.max.y);
    let first = inside.len();
    inside.add_plate(Paint::Mint, 2, [low - WALL, low], along(HEIGHT), &[]);
    inside.add_plate(
        Paint::Cream,
        2,
        [high, high + WALL],
        along(HEIGHT),
        &[store_door],
    );
    inside.paint_inside(first, Paint::Rose, CORRIDOR);
    for room in [CORRIDOR, OFFICES] {
        inside.add_plate(Paint::White, 1, [LOW, LOW + 0.2], room, &[]);
    }
    for x in [13.2, 18.1, 23.0, STORE.min.x - THIN] {
        // The last one stands where the planks end.
        let floor = if x < 25.0 { FLOOR } else { 0.0 };
        let outline = Rect::new(OFFICES.min.y, floor, OFFICES.max.y, LOW);
        let door = Rect::new(27.6, floor, 28.7, DOOR_HEIGHT);
        inside.add_plate(Paint::Cream, 0, [x, x + THIN], outline, &[door]);
    }
    let store = Rect::new(STORE.min.x, 0.0, STORE.max.x, LOW);
    inside.add_plate(Paint::Sky, 2, [STORE.max.y, STORE.max.y + THIN], store, &[]);
    inside.add_plate(Paint::Concrete, 1, [0.0, FLOOR], HALL, &[SHAFT, STAIRS]);
    inside.add_plate(Paint::Slate, 1, [0.0, FLOOR], CORRIDOR, &[]);
    inside
}

fn roof() -> Painted {
    let mut roof = Painted::default();
    let top = HEIGHT + 0.3;
    roof.add_plate(Paint::Steel, 1, [HEIGHT, top], FOOTPRINT, &[SKYLIGHT]);
    let curb = SKYLIGHT.inflate(0.3);
    roof.add_plate(Paint::Concrete, 1, [top, top + 0.4], curb, &[SKYLIGHT]);
    let frame = FOOTPRINT.inflate(-0.3);
    roof.add_plate(Paint::Concrete, 1, [top, top + 0.5], FOOTPRINT, &[frame]);
    // Ventilation.
    for (x, z) in [(13.0, 25.0), (19.0, 24.0), (24.0, 11.0)] {
        roof.add_box(Paint::Slate, [x, top, z], [x + 2.0, top + 1.1, z + 1.4]);
    }
    // Beams under the roof of the hall.
    for x in [12.5, 17.5, 22.5, 27.0] {
        let (low, high) = (HALL.min.y, HALL.max.y);
        roof.add_box(Paint::Red, [x, HEIGHT - 0.4, low], [x + 0.25, HEIGHT, high]);
    }
    roof
}

fn cellar() -> Painted {
    let mut cellar = Painted::default();
    let outer = CELLAR.inflate(WALL);
    let below = CELLAR_FLOOR - WALL;
    cellar.add_plate(Paint::Concrete, 1, [below, CELLAR_FLOOR], outer, &[]);
    cellar.add_plate(Paint::White, 1, [GROUND - 0.1, GROUND], CELLAR, &[SHAFT]);
    let along_x = Rect::new(outer.min.x, CELLAR_FLOOR, outer.max.x, GROUND);
    for z in [outer.min.y, CELLAR.max.y] {
        cellar.add_plate(Paint::Sand, 2, [z, z + WALL], along_x, &[]);
    }
    let along_z = Rect::new(CELLAR.min.y, CELLAR_FLOOR, CELLAR.max.y, GROUND);
    let stairs = Rect::new(STAIRS.min.y, CELLAR_FLOOR, STAIRS.max.y, GROUND);
    cellar.add_plate(
        Paint::Sand,
        0,
        [outer.min.x, CELLAR.min.x],
        along_z,
        &[stairs],
    );
    cellar.add_plate(Paint::Teal, 0, [CELLAR.max.x, outer.max.x], along_z, &[]);
    let doorway = Rect::new(14.5, CELLAR_FLOOR, 15.9, -1.0);
    cellar.add_plate(Paint::Sand, 0, [24.2, 24.4], along_z, &[doorway]);
    // The walls of the stairs, and their steps.
    let well = Rect::new(STAIRS.min.x - WALL, below, outer.min.x, GROUND);
    for z in [STAIRS.min.y - WALL, STAIRS.max.y] {
        cellar.add_plate(Paint::Sand, 2, [z, z + WALL], well, &[]);
    }
    let (x, z) = (STAIRS.min.x, [STAIRS.min.y, STAIRS.max.y]);
    cellar.add_box(Paint::Sand, [x - WALL, below, z[0]], [x, GROUND, z[1]]);
    const STEPS: u32 = 16;
    let tread = (outer.min.x - x) / STEPS as f32;
    for i in 0..STEPS {
        let from = x + tread * i as f32;
        let top = CELLAR_FLOOR / STEPS as f32 * (i + 1) as f32;
        cellar.add_box(
            Paint::Concrete,
            [from, below, z[0]],
            [from + tread, top, z[1]],
        );
    }
    cellar
}

/// Stacks of chests and barrels at these corners.
fn stacks(things: &mut Painted, places: &[(f32, f32)], floor: f32) {
    const BARRELS: [Paint; 3] = [Paint::Navy, Paint::Red, Paint::Orange];
    for (i, (x, z)) in places.iter().enumerate() {
        let random = scatter(i as u32 + 5);
        let at = Vec3::new(*x, floor, *z);
        things.place(chest(1.0), 0.5 * random.x, at);
        things.place(chest(0.7), TAU * random.y, at + Vec3::Y);
        things.place(chest(0.8), 0.3 * random.z, at + Vec3::new(1.25, 0.0, 0.1));
        things.add_cylinder(BARRELS[i % 3], 0.3, 0.9, at + Vec3::new(0.2, 0.0, 1.1));
    }
}

fn hall_things() -> Painted {
    let mut things = Painted::default();
    stacks(
        &mut things,
        &[(9.6, 9.4), (21.5, 15.3), (23.0, 9.3), (31.5, 9.4)],
        FLOOR,
    );
    for (i, x) in [11.0, 14.0, 17.0].into_iter().enumerate() {
        let at = Vec3::new(x, FLOOR, HALL.max.y - 0.02);
        things.place(shelf(2.6, 11 + i as u32), TAU / 2.0, at);
    }
    // Rails around the stairs, but for their beginning.
    for z in [STAIRS.min.y - 0.1, STAIRS.max.y] {
        things.add_box(
            Paint::Yellow,
            [STAIRS.min.x, 0.95, z],
            [STAIRS.max.x, 1.05, z + 0.1],
        );
        for i in 0..8 {
            let x = STAIRS.min.x + 0.6 * i as f32;
            things.add_box(Paint::Yellow, [x, FLOOR, z], [x + 0.06, 0.95, z + 0.1]);
        }
    }
    things
}

fn cellar_things() -> Painted {
    let mut things = Painted::default();
    for (x, z) in [(29.0, 16.5), (22.0, 14.0)] {
        things.add_box(
            Paint::Concrete,
            [x, CELLAR_FLOOR, z],
            [x + 0.4, GROUND, z + 0.4],
        );
    }
    stacks(
        &mut things,
        &[(25.3, 18.3), (31.0, 10.0), (21.0, 18.2)],
        CELLAR_FLOOR,
    );
    for (i, z) in [13.0, 16.0].into_iter().enumerate() {
        let at = Vec3::new(CELLAR.max.x - 0.02, CELLAR_FLOOR, z);
        things.place(shelf(2.4, 40 + i as u32), -FRAC_PI_2, at);
    }
    things.place(
        table(Paint::Wood, [1.6, 0.8, 0.8]),
        0.2,
        Vec3::new(29.2, CELLAR_FLOOR, 18.6),
    );
    things
}

fn office_things() -> Painted {
    let mut things = Painted::default();
    for (i, x) in [10.6, 15.6, 20.6, 25.5].into_iter().enumerate() {
        let at = Vec3::new(x, FLOOR, 23.6);
        things.place(table(Paint::Wood, [1.6, 0.74, 0.8]), 0.0, at);
        things.place(chair(Paint::Coal), TAU / 2.0, at + 0.8 * Vec3::Z);
        things.add_box(
            Paint::Coal,
            [x - 0.3, FLOOR + 0.75, 23.4],
            [x + 0.3, FLOOR + 1.15, 23.46],
        );
        let at = Vec3::new(x, FLOOR, OFFICES.min.y + 0.02);
        things.place(shelf(2.2, 60 + i as u32), 0.0, at);
    }
    stacks(&mut things, &[(29.2, 22.9), (31.6, 21.2)], 0.0);
    things
}

fn corridor_things() -> Painted {
    let mut things = Painted::default();
    let wall = CORRIDOR.min.y;
    for y in [2.25, 2.45] {
        things.add_box(
            Paint::Steel,
            [9.0, y, wall + 0.05],
            [33.5, y + 0.1, wall + 0.15],
        );
    }
    // Doors that stay closed.
    for (x, paint) in [
        (11.5, Paint::Navy),
        (15.5, Paint::Ochre),
        (20.0, Paint::Navy),
        (25.0, Paint::Ochre),
    ] {
        let z = CORRIDOR.max.y;
        things.add_box(paint, [x, FLOOR, z - 0.05], [x + 1.0, 2.15, z]);
        things.add_box(
            Paint::Steel,
            [x + 0.85, 1.0, z - 0.12],
            [x + 0.9, 1.12, z - 0.05],
        );
    }
    things.place(chest(0.7), 0.3, Vec3::new(13.0, FLOOR, 18.1));
    things.add_cylinder(Paint::Orange, 0.3, 0.9, Vec3::new(14.0, FLOOR, 19.5));
    things.place(
        table(Paint::Wood, [1.8, 0.45, 0.4]),
        0.0,
        Vec3::new(18.0, FLOOR, wall + 0.3),
    );
    // The body of the light under the ceiling.
    things.add_box(Paint::White, [15.8, LOW - 0.1, 18.6], [16.8, LOW, 18.9]);
    things
}

/// The closed door of the corridor. Its origin is its hinge.
pub(super) fn door(materials: &Materials) -> ScenePart {
    let mut door = Painted::default();
    door.add_box(
        Paint::Red,
        [0.0; 3],
        [0.06, DOOR_HEIGHT, DOORWAY[1] - DOORWAY[0]],
    );
    let hinge = Vec3::new(FOOTPRINT.min.x, 0.0, DOORWAY[0]);
    ScenePart::new(door.0, &materials.palette, hinge)
}

/// The lift: a platform that closes its shaft when it is up, and a panel that emits light.
pub(super) fn lift(materials: &Materials) -> [ScenePart; 2] {
    let mut lift = Painted::default();
    let Rect { min, max } = SHAFT;
    lift.add_box(Paint::Orange, [min.x, -0.2, min.y], [max.x, FLOOR, max.y]);
    let post = [max.x - 0.2, min.y + 1.4];
    lift.add_box(
        Paint::Coal,
        [post[0], FLOOR, post[1]],
        [post[0] + 0.1, 1.5, post[1] + 0.3],
    );
    for z in [min.y + 0.05, max.y - 0.11] {
        lift.add_box(Paint::Yellow, [min.x, 1.0, z], [max.x, 1.06, z + 0.06]);
        for x in [min.x, 0.5 * (min.x + max.x), max.x - 0.06] {
            lift.add_box(Paint::Yellow, [x, FLOOR, z], [x + 0.06, 1.0, z + 0.06]);
        }
    }
    let panel = ScenePart {
        rotation: Quat::from_rotation_y(-FRAC_PI_2),
        ..ScenePart::new(
            SceneMesh::card(Vec2::new(0.26, 0.4)),
            &materials.panel,
            Vec3::new(post[0] - 0.005, 1.25, post[1] + 0.15),
        )
    };
    [materials.painted(lift), panel]
}

/// How far the lift is moved.
pub(super) fn lift_shift(state: TownState) -> Vec3 {
    match state {
        // The platform lies on the cellar's floor.
        TownState::LiftMoved => (CELLAR_FLOOR + 0.2) * Vec3::Y,
        TownState::Usual | TownState::DoorOpen => Vec3::ZERO,
    }
}

//! The tower: four storeys with stairs, a deck with a parapet, and a roof on posts.

use bevy::math::{Rect, Vec2, Vec3, Vec3Swizzles};

use crate::meshes::{
    scene::SceneMesh,
    town::{
        palette::{Paint, Painted},
        props::chest,
    },
};

const FOOTPRINT: Rect = Rect {
    min: Vec2::new(-35.0, 9.0),
    max: Vec2::new(-29.0, 15.0),
};
const WALL: f32 = 0.3;
const STOREYS: u32 = 4;
const STOREY: f32 = 4.0;
const FLOOR: f32 = 0.25;
/// The steps of a storey.
const STEPS: u32 = 14;
const TREAD: f32 = 0.3;
/// Width of the stairs.
const WIDTH: f32 = 1.0;

pub(super) fn tower() -> Painted {
    let Rect { min, max } = FOOTPRINT;
    let inside = FOOTPRINT.inflate(-WALL);
    let middle = inside.center();
    let deck = STOREY * STOREYS as f32;
    let mut tower = Painted::default();
    let slits = |at: f32, first: u32| {
        let slit = move |storey: u32| {
            let level = STOREY * storey as f32;
            Rect::new(at - 0.4, level + 1.1, at + 0.4, level + 2.9)
        };
        (first..STOREYS).map(slit).collect::<Vec<_>>()
    };
    let first = tower.len();
    for z in [min.y, max.y - WALL] {
        let outline = Rect::new(min.x, 0.0, max.x, deck);
        tower.add_plate(Paint::Brick, 2, [z, z + WALL], outline, &slits(middle.x, 0));
    }
    let outline = Rect::new(inside.min.y, 0.0, inside.max.y, deck);
    let x = [min.x, max.x - WALL];
    tower.add_plate(
        Paint::Brick,
        0,
        [x[0], x[0] + WALL],
        outline,
        &slits(middle.y, 0),
    );
    let mut holes = slits(middle.y, 1);
    holes.push(Rect::new(middle.y - 0.5, 0.0, middle.y + 0.5, 2.2));
    tower.add_plate(Paint::Brick, 0, [x[1], x[1] + WALL], outline, &holes);
    tower.paint_inside(first, Paint::Cream, FOOTPRINT);

    for storey in 0..STOREYS {
        let level = STOREY * storey as f32;
        // Stairs along the walls at both ends of Z in turn, up towards +X.
        let z = if storey.is_multiple_of(2) {
            inside.min.y
        } else {
            inside.max.y - WIDTH
        };
        let start = inside.min.x + 0.6;
        for i in 0..STEPS {
            let from = start + TREAD * i as f32;
            let top = level + STOREY / STEPS as f32 * (i + 1) as f32;
            let low = (top - 0.45).max(level);
            tower.add_box(
                Paint::DarkWood,
                [from, low, z],
                [from + TREAD, top, z + WIDTH],
            );
        }
        let hole = Rect::new(
            start + TREAD * 4.0,
            z,
            start + TREAD * STEPS as f32,
            z + WIDTH,
        );
        let ceiling = [level + STOREY - FLOOR, level + STOREY];
        tower.add_plate(Paint::Wood, 1, ceiling, inside, &[hole]);
        let corner = Vec3::new(inside.max.x - 0.8, level, middle.y + 0.9);
        tower.place(chest(0.8), 0.4, corner);
    }

    let parapet = [deck, deck + 0.9];
    tower.add_plate(Paint::Concrete, 1, parapet, FOOTPRINT, &[inside]);
    for x in [min.x, max.x - WALL] {
        for z in [min.y, max.y - WALL] {
            tower.add_box(
                Paint::Brick,
                [x, deck + 0.9, z],
                [x + WALL, deck + 2.4, z + WALL],
            );
        }
    }
    tower.add(
        Paint::Terracotta,
        pyramid(FOOTPRINT.inflate(0.4), deck + 2.4, 2.2),
    );
    tower
}

/// A closed pyramid over a rectangle.
fn pyramid(base: Rect, level: f32, height: f32) -> SceneMesh {
    let Rect { min, max } = base;
    let at = |x, z| Vec3::new(x, level, z);
    let corners = [
        at(min.x, min.y),
        at(max.x, min.y),
        at(max.x, max.y),
        at(min.x, max.y),
    ];
    let top = base.center().extend(level + height).xzy();
    let mut mesh = SceneMesh::default();
    mesh.add_polygon(&corners);
    for i in 0..4 {
        mesh.add_polygon(&[corners[(i + 1) % 4], corners[i], top]);
    }
    mesh
}

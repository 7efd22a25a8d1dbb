//! A house: rooms with doorways, windows without glass, stairs, furniture and a roof. And the tower: four storeys with
//! stairs, a deck with a parapet, and a roof on posts.

use bevy::math::{Rect, Vec2, Vec3, Vec3Swizzles};

use crate::meshes::{
    SceneMesh,
    town::things::{Paint, Painted, chest, furnish},
};

/// Thickness of outer walls, of walls between rooms, and of floors.
const OUTER: f32 = 0.3;
const INNER: f32 = 0.2;
const FLOOR: f32 = 0.2;
/// From floor to floor.
const STOREY: f32 = 2.8;
/// Top of the lowest floor.
const BASE: f32 = 0.1;
/// A window's width and the heights of its edges above the floor's level.
const WINDOW: f32 = 1.3;
const SILL: f32 = 0.95;
const HEAD: f32 = 2.15;
/// Width of a door; its height is that of windows.
const DOOR: f32 = 1.0;
/// Steps of the stairs.
const STEPS: u32 = 14;
const TREAD: f32 = 0.26;

#[derive(Clone, Copy)]
pub(super) struct House {
    /// X and Z of its outer corners.
    pub footprint: Rect,
    pub storeys: u32,
    /// Whether the door is at the end of Z, or else at its beginning.
    pub is_door_at_end: bool,
    pub outside: Paint,
    pub rooms: Paint,
    pub roof: Roof,
}

#[derive(Clone, Copy)]
pub(super) enum Roof {
    Gable(Paint),
    Flat,
}

/// The middles of the windows of a wall, an even number, as a wall between rooms meets its middle.
fn windows(from: f32, to: f32) -> impl Iterator<Item = f32> {
    let count = 2 * ((to - from) / 5.5).round().max(1.0) as u32;
    (0..count).map(move |i| from + (i as f32 + 0.5) * (to - from) / count as f32)
}

impl House {
    pub fn mesh(&self) -> Painted {
        let Rect { min, max } = self.footprint;
        let inside = self.footprint.inflate(-OUTER);
        let height = STOREY * self.storeys as f32;
        let mut house = Painted::default();
        self.add_outer_walls(&mut house, height);
        let middle = inside.center();
        for storey in 0..self.storeys {
            let level = STOREY * storey as f32;
            let is_top = storey + 1 == self.storeys;
            self.add_floor(&mut house, level, storey > 0);
            self.add_inner_walls(&mut house, storey);
            let floor = if storey == 0 { BASE } else { level };
            let (wall, seed) = (0.5 * INNER, 3 * storey + min.x.abs() as u32);
            let left = Rect::from_corners(inside.min, Vec2::new(middle.x - wall, middle.y - wall));
            let front = Rect::new(inside.min.x, middle.y + wall, middle.x - wall, inside.max.y);
            let right = Rect::new(middle.x + wall, inside.min.y, inside.max.x, inside.max.y);
            let rooms = [(right, seed + 2), (left, seed), (front, seed + 1)];
            // Upstairs only the largest one has furniture.
            let furnished = if storey == 0 { 3 } else { 1 };
            for (room, seed) in rooms.into_iter().take(furnished) {
                house.place(furnish(room, floor, seed), 0.0, Vec3::ZERO);
            }
            if !is_top {
                add_stairs(&mut house, middle.x + wall, inside.min.y, level);
            }
        }
        let ceiling = [height - FLOOR, height];
        house.add_plate(Paint::White, 1, ceiling, inside, &[]);
        match self.roof {
            Roof::Gable(paint) => {
                house.add(paint, gable(self.footprint.inflate(0.45), height, 2.4));
            }
            Roof::Flat => {
                let top = [height, height + 0.25];
                house.add_plate(Paint::Slate, 1, top, self.footprint, &[]);
                let rail = [height + 0.25, height + 0.9];
                let frame = self.footprint.inflate(-0.2);
                house.add_plate(self.outside, 1, rail, self.footprint, &[frame]);
            }
        }
        // A step before the door.
        let (door, z) = (
            self.door(),
            if self.is_door_at_end {
                max.y
            } else {
                min.y - 0.6
            },
        );
        house.add_box(
            Paint::Concrete,
            [door - 0.8, 0.0, z],
            [door + 0.8, 0.08, z + 0.6],
        );
        house
    }

    /// The middle of the door.
    fn door(&self) -> f32 {
        let Rect { min, max } = self.footprint;
        let mut middles = windows(min.x, max.x);
        let count = windows(min.x, max.x).count();
        middles.nth(count / 2).unwrap_or_default()
    }

    fn add_outer_walls(&self, house: &mut Painted, height: f32) {
        let Rect { min, max } = self.footprint;
        let holes = |from, to, door: Option<f32>| {
            let storeys = 0..self.storeys;
            let of_storey = move |storey: u32| {
                let level = STOREY * storey as f32;
                windows(from, to).map(move |x| match door {
                    Some(door) if storey == 0 && x == door => {
                        Rect::new(x - 0.5 * DOOR, 0.0, x + 0.5 * DOOR, HEAD)
                    }
                    _ => Rect::new(
                        x - 0.5 * WINDOW,
                        level + SILL,
                        x + 0.5 * WINDOW,
                        level + HEAD,
                    ),
                })
            };
            storeys.flat_map(of_storey).collect::<Vec<_>>()
        };
        let first = house.len();
        for (z, is_end) in [(min.y, false), (max.y - OUTER, true)] {
            let door = (is_end == self.is_door_at_end).then(|| self.door());
            house.add_plate(
                self.outside,
                2,
                [z, z + OUTER],
                Rect::new(min.x, 0.0, max.x, height),
                &holes(min.x, max.x, door),
            );
        }
        let (from, to) = (min.y + OUTER, max.y - OUTER);
        for x in [min.x, max.x - OUTER] {
            let outline = Rect::new(from, 0.0, to, height);
            house.add_plate(
                self.outside,
                0,
                [x, x + OUTER],
                outline,
                &holes(from, to, None),
            );
        }
        house.paint_inside(first, self.rooms, self.footprint);
    }

    fn add_floor(&self, house: &mut Painted, level: f32, is_above_another: bool) {
        let inside = self.footprint.inflate(-OUTER);
        if is_above_another {
            let stairs = stairwell(inside.center().x + 0.5 * INNER, inside.min.y);
            let below = level - 0.5 * FLOOR;
            house.add_plate(Paint::White, 1, [level - FLOOR, below], inside, &[stairs]);
            house.add_plate(Paint::Wood, 1, [below, level], inside, &[stairs]);
        } else {
            house.add_plate(Paint::Wood, 1, [0.0, BASE], inside, &[]);
        }
    }

    /// A wall along Z in the middle, and one from it to the wall at the beginning of X.
    fn add_inner_walls(&self, house: &mut Painted, storey: u32) {
        let inside = self.footprint.inflate(-OUTER);
        let (middle, half) = (inside.center(), 0.5 * INNER);
        let level = STOREY * storey as f32;
        let [low, high] = [
            if storey == 0 { BASE } else { level },
            level + STOREY - FLOOR,
        ];
        let doorway = |at: f32| Rect::new(at - 0.5 * DOOR, low, at + 0.5 * DOOR, level + HEAD);
        house.add_plate(
            self.rooms,
            0,
            [middle.x - half, middle.x + half],
            Rect::new(inside.min.y, low, inside.max.y, high),
            &[doorway(inside.max.y - 1.2)],
        );
        house.add_plate(
            self.rooms,
            2,
            [middle.y - half, middle.y + half],
            Rect::new(inside.min.x, low, middle.x - half, high),
            &[doorway(middle.x - 1.2)],
        );
    }
}

/// The hole above stairs that begin at this corner.
fn stairwell(x: f32, z: f32) -> Rect {
    Rect::new(x, z + 0.5, x + 1.0, z + 0.5 + TREAD * STEPS as f32)
}

/// Stairs up towards -Z, with a landing at the end.
fn add_stairs(house: &mut Painted, x: f32, z: f32, level: f32) {
    let base = if level == 0.0 { BASE } else { level };
    let well = stairwell(x, z);
    let rise = (level + STOREY - base) / STEPS as f32;
    for i in 0..STEPS {
        let top = base + rise * (i + 1) as f32;
        let end = well.max.y - TREAD * i as f32;
        house.add_box(
            Paint::DarkWood,
            [x, (top - rise - 0.1).max(base), end - TREAD],
            [x + 1.0, top, end],
        );
    }
}

/// A closed prism over a rectangle whose ridge is along X.
pub(super) fn gable(base: Rect, level: f32, height: f32) -> SceneMesh {
    let Rect { min, max } = base;
    let ridge = 0.5 * (min.y + max.y);
    let eave = |x, z| Vec3::new(x, level, z);
    let top = |x| Vec3::new(x, level + height, ridge);
    let mut mesh = SceneMesh::default();
    mesh.add_polygon(&[
        eave(min.x, min.y),
        eave(max.x, min.y),
        eave(max.x, max.y),
        eave(min.x, max.y),
    ]);
    mesh.add_polygon(&[
        eave(min.x, max.y),
        eave(max.x, max.y),
        top(max.x),
        top(min.x),
    ]);
    mesh.add_polygon(&[
        eave(max.x, min.y),
        eave(min.x, min.y),
        top(min.x),
        top(max.x),
    ]);
    mesh.add_polygon(&[eave(max.x, max.y), eave(max.x, min.y), top(max.x)]);
    mesh.add_polygon(&[eave(min.x, min.y), eave(min.x, max.y), top(min.x)]);
    mesh
}

/// The tower.
pub(super) fn tower() -> Painted {
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

//! The colours of the town, cells of one texture, each of which a surface has by its texture coordinates; and furniture
//! and other small things.

use std::{f32::consts::TAU, sync::Arc};

use bevy::math::{EulerRot, Quat, Rect, Vec2, Vec3};
use image::{Rgba, RgbaImage};

use crate::meshes::{SceneMaterial, SceneMesh, SceneTexture};

/// Cells along an edge of the texture, and pixels along an edge of a cell.
const CELLS: u32 = 5;
const CELL: u32 = 8;

/// A cell of the palette.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Paint {
    White,
    Cream,
    Ochre,
    Brick,
    Rose,
    Sky,
    Navy,
    Teal,
    Mint,
    Moss,
    Grass,
    Wood,
    DarkWood,
    Bark,
    Concrete,
    Slate,
    Steel,
    Coal,
    Red,
    Orange,
    Yellow,
    Purple,
    Terracotta,
    Sand,
    Asphalt,
}

/// Their colours, encoded in sRGB.
const COLORS: [[u8; 3]; 25] = [
    [232, 230, 224],
    [228, 212, 178],
    [206, 160, 84],
    [158, 78, 62],
    [214, 150, 140],
    [150, 184, 214],
    [44, 62, 110],
    [46, 128, 132],
    [160, 206, 170],
    [84, 108, 58],
    [104, 142, 62],
    [170, 124, 80],
    [104, 70, 46],
    [84, 66, 52],
    [172, 170, 164],
    [96, 104, 114],
    [140, 148, 156],
    [52, 52, 56],
    [186, 44, 40],
    [222, 122, 44],
    [234, 196, 62],
    [112, 70, 136],
    [186, 96, 66],
    [216, 198, 158],
    [88, 88, 90],
];

/// The palette's material.
pub(super) fn palette() -> Arc<SceneMaterial> {
    let pixels = RgbaImage::from_fn(CELLS * CELL, CELLS * CELL, |x, y| {
        let [r, g, b] = COLORS[(y / CELL * CELLS + x / CELL) as usize];
        Rgba([r, g, b, 255])
    });
    Arc::new(SceneMaterial {
        texture: Some(Arc::new(SceneTexture::new(pixels))),
        ..SceneMaterial::default()
    })
}

impl Paint {
    /// The middle of the cell.
    fn uv(self) -> Vec2 {
        let cell = self as u32;
        (Vec2::new((cell % CELLS) as f32, (cell / CELLS) as f32) + 0.5) / CELLS as f32
    }
}

/// A mesh in colours of the palette.
#[derive(Clone, Default)]
pub(super) struct Painted(pub SceneMesh);

impl Painted {
    pub fn add(&mut self, paint: Paint, mut mesh: SceneMesh) {
        mesh.uvs.fill(paint.uv());
        self.0.append(mesh, Vec3::ZERO);
    }

    pub fn add_box(&mut self, paint: Paint, low: [f32; 3], high: [f32; 3]) {
        self.add(paint, SceneMesh::cuboid(low.into(), high.into()));
    }

    /// Boxes that fill an outline but for its holes, as [`SceneMesh::add_plate`] does.
    pub fn add_plate(
        &mut self,
        paint: Paint,
        axis: usize,
        range: [f32; 2],
        outline: Rect,
        holes: &[Rect],
    ) {
        let mut mesh = SceneMesh::default();
        mesh.add_plate(axis, range, outline, holes);
        self.add(paint, mesh);
    }

    /// Adds another one, rotated about its origin and then moved.
    pub fn place(&mut self, other: Self, turn: f32, at: Vec3) {
        self.0
            .append_rotated(other.0, Quat::from_rotation_y(turn), at);
    }

    pub fn add_cylinder(&mut self, paint: Paint, radius: f32, height: f32, at: Vec3) {
        let mut mesh = SceneMesh::default();
        mesh.append(SceneMesh::cylinder(radius, height, 12), at);
        self.add(paint, mesh);
    }

    /// Paints what faces the inside of a room or house, of which these are the corners, with another colour.
    pub fn paint_inside(&mut self, first: usize, paint: Paint, inside: Rect) {
        let mesh = &mut self.0;
        let faces = mesh.positions[first..].chunks_exact(4);
        let faces = faces.zip(mesh.normals[first..].chunks_exact(4));
        for ((corners, normals), uvs) in faces.zip(mesh.uvs[first..].chunks_exact_mut(4)) {
            let before = 0.25 * corners.iter().sum::<Vec3>() + 0.01 * normals[0];
            if inside.contains(Vec2::new(before.x, before.z)) {
                uvs.fill(paint.uv());
            }
        }
    }

    /// Number of vertices.
    pub fn len(&self) -> usize {
        self.0.positions.len()
    }
}

/// Even numbers between 0 and 1 without order, the same for the same index.
pub(super) fn scatter(index: u32) -> Vec3 {
    let at = |step: f64| (0.5 + step * f64::from(index)).fract() as f32;
    // The R3 sequence.
    Vec3::new(at(0.819_172_5), at(0.671_043_6), at(0.549_700_5))
}

/// A table or a bench: a top of this size at a height, on four legs.
pub(super) fn table(paint: Paint, [width, height, depth]: [f32; 3]) -> Painted {
    let mut table = Painted::default();
    let (x, z, leg) = (0.5 * width, 0.5 * depth, 0.07);
    table.add_box(paint, [-x, height - 0.06, -z], [x, height, z]);
    for (sx, sz) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
        let [a, b] = [x - 0.05 - leg, z - 0.05 - leg].map(|inner| [inner, inner + leg]);
        let [x0, x1] = if sx < 0.0 { [-a[1], -a[0]] } else { a };
        let [z0, z1] = if sz < 0.0 { [-b[1], -b[0]] } else { b };
        table.add_box(paint, [x0, 0.0, z0], [x1, height - 0.06, z1]);
    }
    table
}

/// A chair that faces +Z.
pub(super) fn chair(paint: Paint) -> Painted {
    let mut chair = table(paint, [0.45, 0.46, 0.45]);
    chair.add_box(paint, [-0.225, 0.46, -0.225], [0.225, 1.0, -0.17]);
    chair
}

/// A bed with its head at -Z.
pub(super) fn bed(cover: Paint) -> Painted {
    let mut bed = Painted::default();
    bed.add_box(Paint::DarkWood, [-0.7, 0.0, -1.05], [0.7, 0.28, 1.05]);
    bed.add_box(Paint::DarkWood, [-0.7, 0.0, -1.15], [0.7, 0.95, -1.05]);
    bed.add_box(cover, [-0.66, 0.28, -0.45], [0.66, 0.5, 1.02]);
    bed.add_box(Paint::White, [-0.5, 0.28, -1.02], [0.5, 0.46, -0.5]);
    bed
}

/// A shelf of this width that faces +Z, with things of several colours on its boards.
pub(super) fn shelf(width: f32, seed: u32) -> Painted {
    const THINGS: [Paint; 6] = [
        Paint::Red,
        Paint::Teal,
        Paint::Yellow,
        Paint::Navy,
        Paint::Orange,
        Paint::White,
    ];
    let mut shelf = Painted::default();
    let x = 0.5 * width;
    for side in [-x, x - 0.04] {
        shelf.add_box(Paint::Wood, [side, 0.0, 0.0], [side + 0.04, 1.6, 0.4]);
    }
    for board in 0..3 {
        let y = 0.1 + 0.6 * board as f32;
        shelf.add_box(Paint::Wood, [0.04 - x, y, 0.0], [x - 0.04, y + 0.04, 0.4]);
        let mut at = 0.1 - x;
        for thing in 0.. {
            let random = scatter(seed + 31 * board + thing);
            let thick = 0.25 + 0.3 * random.x;
            if at + thick > x - 0.1 {
                break;
            }
            let paint = THINGS[(seed + 7 * board + thing) as usize % THINGS.len()];
            let high = y
                + 0.04
                + if board == 2 {
                    0.1
                } else {
                    0.15 + 0.25 * random.y
                };
            shelf.add_box(paint, [at, y + 0.04, 0.05], [at + thick, high, 0.35]);
            at += thick + 0.08 + 0.3 * random.z;
        }
    }
    shelf
}

/// A chest of this edge: a box in a frame of laths.
pub(super) fn chest(size: f32) -> Painted {
    let mut chest = Painted::default();
    let (half, lath) = (0.5 * size, 0.08 * size);
    let inner = half - 0.2 * lath;
    chest.add_box(
        Paint::Wood,
        [-inner, 0.0, -inner],
        [inner, size - 0.02, inner],
    );
    for (x, z) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
        let center = (half - 0.5 * lath) * Vec2::new(x, z);
        let (low, high) = (center - 0.5 * lath, center + 0.5 * lath);
        chest.add_box(Paint::DarkWood, [low.x, 0.0, low.y], [high.x, size, high.y]);
    }
    chest
}

/// Cards of leaves of this edge, even over an ellipsoid around the origin.
pub(super) fn leaves(count: u32, radii: Vec3, edge: f32) -> SceneMesh {
    let mut mesh = SceneMesh::default();
    for i in 0..count {
        let random = scatter(i);
        // Golden angles from the bottom to the top, in the outer part of the ellipsoid.
        let (angle, y) = (
            2.399_963 * i as f32,
            2.0 * (i as f32 + 0.5) / count as f32 - 1.0,
        );
        let ring = (1.0 - y * y).sqrt();
        let at =
            (0.55 + 0.45 * random.x) * radii * Vec3::new(ring * angle.cos(), y, ring * angle.sin());
        let turn = Quat::from_euler(
            EulerRot::YXZ,
            TAU / 4.0 - angle + 0.6 * (random.y - 0.5),
            -0.7 * y + 0.8 * (random.z - 0.5),
            TAU * random.y,
        );
        mesh.append_rotated(SceneMesh::card(Vec2::splat(edge)), turn, at);
    }
    mesh
}

/// Furniture of a room: what there is depends on the seed.
pub(super) fn furnish(room: Rect, floor: f32, seed: u32) -> Painted {
    let mut furniture = Painted::default();
    let (low, high) = (room.min, room.max);
    let at = |x: f32, z: f32| Vec3::new(x, floor, z);
    let middle = room.center();
    let rug = [Paint::Red, Paint::Navy, Paint::Ochre, Paint::Teal][seed as usize % 4];
    let half = (0.28 * room.size()).min(Vec2::splat(1.6));
    furniture.add_box(
        rug,
        [middle.x - half.x, floor, middle.y - half.y],
        [middle.x + half.x, floor + 0.02, middle.y + half.y],
    );
    if seed.is_multiple_of(2) {
        let at = at(middle.x, middle.y) + 0.02 * Vec3::Y;
        furniture.place(table(Paint::Wood, [1.5, 0.76, 0.9]), 0.1, at);
        for (turn, side) in [(0.0, -0.75), (TAU / 2.0, 0.75)] {
            furniture.place(chair(Paint::DarkWood), turn, at + side * Vec3::Z);
        }
        furniture.add_cylinder(Paint::Sky, 0.12, 0.22, at + 0.76 * Vec3::Y);
    } else {
        let at = at(low.x + 0.85, high.y - 1.25);
        furniture.place(bed(Paint::Rose), TAU / 2.0, at);
    }
    // Along the wall at -Z.
    let width = (0.5 * room.width()).min(2.0);
    let corner = at(high.x - 0.5 * width - 0.15, low.y + 0.02);
    furniture.place(shelf(width, seed), 0.0, corner);
    furniture
}

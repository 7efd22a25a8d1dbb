//! The colours of the town: cells of one texture, each of which a surface has by its texture coordinates.

use std::sync::Arc;

use bevy::math::{Rect, Vec2, Vec3};
use image::{Rgba, RgbaImage};

use crate::meshes::scene::{SceneMaterial, SceneMesh, SceneTexture};

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
pub(super) fn material() -> Arc<SceneMaterial> {
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

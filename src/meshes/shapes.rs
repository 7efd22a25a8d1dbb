//! Meshes and materials made in code. The texture coordinates of meshes are in metres, but for grids.

use std::{
    f32::consts::{PI, TAU},
    sync::Arc,
};

use bevy::math::{Quat, Rect, Vec2, Vec3};
use image::{RgbImage, RgbaImage, buffer::ConvertBuffer};

use crate::{
    content,
    meshes::{SceneMaterial, SceneMesh, SceneTexture},
};

impl SceneMesh {
    /// Adds a flat polygon, convex and counter-clockwise seen from its front.
    pub fn add_polygon(&mut self, corners: &[Vec3]) {
        let normal = (corners[1] - corners[0])
            .cross(corners[2] - corners[0])
            .normalize_or_zero();
        let uvs = corners.iter().map(|corner| planar_uv(*corner, normal));
        let uvs: Vec<_> = uvs.collect();
        self.add_fan(corners, &vec![normal; corners.len()], &uvs);
    }

    /// Adds a convex polygon as a fan around its first corner.
    fn add_fan(&mut self, corners: &[Vec3], normals: &[Vec3], uvs: &[Vec2]) {
        let first = self.positions.len() as u32;
        self.positions.extend(corners);
        self.normals.extend(normals);
        self.uvs.extend(uvs);
        for k in 1..corners.len() as u32 - 1 {
            self.indices.extend([first, first + k, first + k + 1]);
        }
    }

    /// Adds a box from corner to corner.
    pub fn add_box(&mut self, low: Vec3, high: Vec3) {
        for axis in 0..3 {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            for is_high in [false, true] {
                let corner = |along_u: bool, along_v: bool| {
                    let mut at = if is_high { high } else { low };
                    at[u] = if along_u { high[u] } else { low[u] };
                    at[v] = if along_v { high[v] } else { low[v] };
                    at
                };
                let mut corners = [
                    corner(false, false),
                    corner(true, false),
                    corner(true, true),
                    corner(false, true),
                ];
                if !is_high {
                    corners.reverse();
                }
                self.add_polygon(&corners);
            }
        }
    }

    /// A box from corner to corner.
    pub fn cuboid(low: Vec3, high: Vec3) -> Self {
        let mut mesh = Self::default();
        mesh.add_box(low, high);
        mesh
    }

    /// Adds boxes that fill an outline but for its holes, which do not overlap. They extend over `range` along an
    /// axis; rectangles are in Z and Y for the axis X, in X and Z for Y, and in X and Y for Z.
    pub fn add_plate(&mut self, axis: usize, range: [f32; 2], outline: Rect, holes: &[Rect]) {
        let corner = |along: f32, at: Vec2| match axis {
            0 => Vec3::new(along, at.y, at.x),
            1 => Vec3::new(at.x, along, at.y),
            _ => at.extend(along),
        };
        let mut add = |low, high| self.add_box(corner(range[0], low), corner(range[1], high));
        let ends = holes.iter().chain([&outline]);
        let mut cuts: Vec<_> = ends.flat_map(|rect| [rect.min.x, rect.max.x]).collect();
        cuts.sort_by(f32::total_cmp);
        cuts.dedup();
        for strip in cuts.windows(2) {
            let is_cut = |hole: &&Rect| hole.min.x <= strip[0] && strip[1] <= hole.max.x;
            let mut across: Vec<_> = holes.iter().filter(is_cut).collect();
            across.sort_by(|a, b| a.min.y.total_cmp(&b.min.y));
            let mut from = outline.min.y;
            for hole in across {
                if from < hole.min.y {
                    add(Vec2::new(strip[0], from), Vec2::new(strip[1], hole.min.y));
                }
                from = hole.max.y;
            }
            if from < outline.max.y {
                add(
                    Vec2::new(strip[0], from),
                    Vec2::new(strip[1], outline.max.y),
                );
            }
        }
    }

    /// A cylinder around Y that stands on the origin, with a flat top, open below.
    pub fn cylinder(radius: f32, height: f32, sides: u32) -> Self {
        let point = |i: u32, y: f32| {
            let (sin, cos) = (TAU * i as f32 / sides as f32).sin_cos();
            Vec3::new(radius * cos, y, -radius * sin)
        };
        let mut mesh = Self::default();
        for i in 0..sides {
            let corners = [
                point(i, 0.0),
                point(i + 1, 0.0),
                point(i + 1, height),
                point(i, height),
            ];
            let first = mesh.normals.len();
            mesh.add_polygon(&corners);
            for (normal, corner) in mesh.normals[first..].iter_mut().zip(corners) {
                *normal = corner.with_y(0.0).normalize_or_zero();
            }
        }
        let lid: Vec<_> = (0..sides).map(|i| point(i, height)).collect();
        mesh.add_polygon(&lid);
        mesh
    }

    /// Texture coordinates in repetitions of a texture that is this long in metres.
    pub fn repeated(mut self, metres: f32) -> Self {
        for uv in &mut self.uvs {
            *uv /= metres;
        }
        self
    }

    /// Adds another mesh, moved.
    pub fn append(&mut self, other: Self, translation: Vec3) {
        self.append_rotated(other, Quat::IDENTITY, translation);
    }

    /// Adds another mesh, rotated about its origin and then moved.
    pub fn append_rotated(&mut self, other: Self, rotation: Quat, translation: Vec3) {
        let first = self.positions.len() as u32;
        let place = |position| rotation * position + translation;
        self.positions
            .extend(other.positions.into_iter().map(place));
        let rotate = |normal| rotation * normal;
        self.normals.extend(other.normals.into_iter().map(rotate));
        self.uvs.extend(other.uvs);
        self.indices
            .extend(other.indices.into_iter().map(|index| first + index));
    }

    /// A rectangle of this size in the plane of X and Y that faces +Z, with texture coordinates from 0 to 1.
    pub fn card(size: Vec2) -> Self {
        let corners = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)].map(Vec2::from);
        let mut mesh = Self::default();
        mesh.add_fan(
            &corners.map(|corner| (corner * size).extend(0.0)),
            &[Vec3::Z; 4],
            &corners.map(|corner| Vec2::new(corner.x + 0.5, 0.5 - corner.y)),
        );
        mesh
    }

    /// Adds a wall with a round arch, seen along -Z: from X `-0.5 * width` to `0.5 * width`, from the floor to
    /// `height`, `depth` thick about Z 0. The arch has this radius and begins at the height of `spring`; half of
    /// a pier is at each side.
    pub fn add_arch(&mut self, width: f32, height: f32, depth: f32, radius: f32, spring: f32) {
        const SEGMENTS: usize = 32;
        let (half, z) = (0.5 * width, 0.5 * depth);
        let point = |i: usize| {
            let (sin, cos) = (PI * i as f32 / SEGMENTS as f32).sin_cos();
            Vec3::new(radius * cos, spring + radius * sin, 0.0)
        };
        let front = Vec3::new(0.0, 0.0, z);
        let mut add_both_faces = |corners: &[Vec3]| {
            let shifted: Vec<_> = corners.iter().map(|corner| *corner + front).collect();
            self.add_polygon(&shifted);
            let shifted: Vec<_> = corners.iter().rev().map(|corner| *corner - front).collect();
            self.add_polygon(&shifted);
        };
        let at = |x: f32, y: f32| Vec3::new(x, y, 0.0);
        add_both_faces(&[
            at(radius, 0.0),
            at(half, 0.0),
            at(half, spring),
            at(radius, spring),
        ]);
        add_both_faces(&[
            at(-half, 0.0),
            at(-radius, 0.0),
            at(-radius, spring),
            at(-half, spring),
        ]);
        for i in 0..SEGMENTS {
            let (a, b) = (point(i), point(i + 1));
            // What is beside the arch goes to the wall's edges, and above them to its top.
            let outer = |p: Vec3| {
                let t =
                    (half / p.x.abs().max(1e-6)).min((height - spring) / (p.y - spring).max(1e-6));
                at(t * p.x, spring + t * (p.y - spring))
            };
            let (c, d) = (outer(b), outer(a));
            let is_at_top = |p: Vec3| p.y > height - 1e-4;
            let is_at_side = |p: Vec3| p.x.abs() > half - 1e-4;
            let corner = at(half * (a.x + b.x).signum(), height);
            if is_at_top(c) != is_at_top(d) && is_at_side(c) != is_at_side(d) {
                add_both_faces(&[a, d, corner, c, b]);
            } else {
                add_both_faces(&[a, d, c, b]);
            }
        }
        // The inside: two flat parts and the vault, whose normals point to the arch's centre.
        let inward = |p: Vec3| (at(0.0, spring) - p).normalize();
        for side in [1.0, -1.0] {
            let (x, near, far) = (side * radius, side * z, -side * z);
            self.add_polygon(&[
                Vec3::new(x, 0.0, near),
                Vec3::new(x, spring, near),
                Vec3::new(x, spring, far),
                Vec3::new(x, 0.0, far),
            ]);
        }
        for i in 0..SEGMENTS {
            let (a, b) = (point(i), point(i + 1));
            let [u, v] = [i, i + 1].map(|i| spring + PI * radius * i as f32 / SEGMENTS as f32);
            self.add_fan(
                &[a + front, b + front, b - front, a - front],
                &[inward(a), inward(b), inward(b), inward(a)],
                &[
                    Vec2::new(z, u),
                    Vec2::new(z, v),
                    Vec2::new(-z, v),
                    Vec2::new(-z, u),
                ],
            );
        }
    }

    /// A closed surface of `2 * columns * rows` triangles around a curve, both of which repeat after 1: `at`
    /// gives the point for two coordinates from 0 to 1.
    pub fn grid(columns: u32, rows: u32, at: impl Fn(Vec2) -> Vec3) -> Self {
        let mut mesh = Self::default();
        let step = Vec2::new(1.0 / columns as f32, 1.0 / rows as f32);
        for row in 0..=rows {
            for column in 0..=columns {
                let uv = Vec2::new(column as f32, row as f32) * step;
                // Central differences over half a cell.
                let [du, dv] = [0.25 * step.with_y(0.0), 0.25 * step.with_x(0.0)];
                let normal = (at(uv + du) - at(uv - du)).cross(at(uv + dv) - at(uv - dv));
                mesh.positions.push(at(uv));
                mesh.normals.push(normal.normalize_or_zero());
                mesh.uvs.push(uv);
            }
        }
        for row in 0..rows {
            for column in 0..columns {
                let a = row * (columns + 1) + column;
                let b = a + columns + 1;
                mesh.indices.extend([a, a + 1, b + 1, a, b + 1, b]);
            }
        }
        mesh
    }
}

/// Texture coordinates of a flat surface, in metres.
fn planar_uv(at: Vec3, normal: Vec3) -> Vec2 {
    match normal.abs().max_position() {
        0 => Vec2::new(at.z, -at.y),
        1 => Vec2::new(at.x, at.z),
        _ => Vec2::new(at.x, -at.y),
    }
}

/// Side of the textures in pixels.
pub(super) const SIZE: u32 = 256;
pub(super) const SEED: u64 = 5;

pub(super) fn colored(albedo: Vec3) -> Arc<SceneMaterial> {
    Arc::new(SceneMaterial {
        albedo,
        ..SceneMaterial::default()
    })
}

pub(super) fn textured(image: RgbImage) -> Arc<SceneMaterial> {
    Arc::new(SceneMaterial {
        texture: Some(Arc::new(SceneTexture::new(image.convert()))),
        ..SceneMaterial::default()
    })
}

/// Encoded levels times a factor.
pub(super) fn brightened(mut image: RgbImage, factor: f32) -> RgbImage {
    for pixel in image.pixels_mut() {
        pixel.0 = pixel
            .0
            .map(|level| (f32::from(level) * factor).min(240.0) as u8);
    }
    image
}

/// Leaves with holes between them.
pub(super) fn leaves() -> Arc<SceneMaterial> {
    let foliage = content::foliage(SIZE, SIZE, SEED);
    Arc::new(SceneMaterial {
        texture: Some(Arc::new(SceneTexture::new(foliage.masked_color()))),
        alpha_cutoff: Some(0.5),
        is_double_sided: true,
        ..SceneMaterial::default()
    })
}

/// Bright letters that emit light, on a dim ground.
pub(super) fn sign(text: &str, emission: Vec3) -> Arc<SceneMaterial> {
    let letters = content::label(text, 64);
    let mut image = RgbaImage::from_pixel(
        letters.width() + 32,
        letters.height(),
        image::Rgba([70, 70, 70, 255]),
    );
    for (x, y, pixel) in letters.enumerate_pixels() {
        let level = pixel.0[3].max(70);
        image.put_pixel(x + 16, y, image::Rgba([level, level, level, 255]));
    }
    Arc::new(SceneMaterial {
        albedo: Vec3::ZERO,
        emission,
        emissive_texture: Some(Arc::new(SceneTexture::new(image))),
        ..SceneMaterial::default()
    })
}

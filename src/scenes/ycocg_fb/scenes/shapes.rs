//! What the scenes have in common: materials, flat shapes and randomness.

use bevy::{asset::RenderAssetUsages, mesh::PrimitiveTopology, prelude::*};
use image::{DynamicImage, RgbImage};

use crate::content::{self, mipped_texture};

pub(super) const SEED: u64 = 7;

pub fn add(world: &mut World, mesh: impl Into<Mesh>, material: StandardMaterial, pose: Transform) {
    let mesh = world.add_asset(mesh);
    let material = world.add_asset::<StandardMaterial>(material);
    world.spawn((Mesh3d(mesh), MeshMaterial3d(material), pose));
}

pub(super) fn textured(world: &mut World, source: content::Material) -> StandardMaterial {
    let mut add = |image: RgbImage, is_srgb| {
        let image = DynamicImage::from(image).into_rgba8();
        Some(world.add_asset(mipped_texture(&image, is_srgb)))
    };
    StandardMaterial {
        base_color_texture: add(source.color, true),
        normal_map_texture: add(source.normal, false),
        ..default()
    }
}

/// A material whose pixels have exactly this colour, scene-linear.
pub(super) fn flat(color: LinearRgba) -> StandardMaterial {
    StandardMaterial {
        base_color: color.into(),
        unlit: true,
        double_sided: true,
        cull_mode: None,
        ..default()
    }
}

/// Triangles in the plane of the screen, three corners each.
pub(super) fn triangles(corners: &[Vec2]) -> Mesh {
    let positions: Vec<[f32; 3]> = corners.iter().map(|c| [c.x, c.y, 0.0]).collect();
    let normals = vec![[0.0, 0.0, 1.0]; positions.len()];
    let uvs = vec![[0.0, 0.0]; positions.len()];
    Mesh::new(
        PrimitiveTopology::TriangleList,
        RenderAssetUsages::RENDER_WORLD,
    )
    .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
    .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, normals)
    .with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, uvs)
}

/// Corners of a line of `width` pixels.
pub(super) fn line(from: Vec2, to: Vec2, width: f32) -> [Vec2; 6] {
    let side = (to - from).normalize_or_zero().perp() * (width / 2.0);
    let [a, b, c, d] = [from - side, from + side, to - side, to + side];
    [a, b, c, c, b, d]
}

/// A repeatable sequence of numbers of 0 to 1 (a 64-bit linear congruential generator with Knuth's
/// multiplier; the upper half of its state).
pub(super) struct Random(u64);

impl Random {
    pub(super) fn new(seed: u64) -> Self {
        Self(seed)
    }

    pub(super) fn next(&mut self) -> f32 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1u64 << 24) as f32
    }

    pub(super) fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.next()
    }
}

//! Materials of textures that are made in code.

use std::sync::Arc;

use bevy::math::Vec3;
use image::{DynamicImage, RgbImage, RgbaImage};

use crate::{
    content,
    meshes::scene::{SceneMaterial, SceneTexture},
};

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
        texture: Some(Arc::new(SceneTexture::new(rgba(image)))),
        ..SceneMaterial::default()
    })
}

pub(super) fn rgba(image: RgbImage) -> RgbaImage {
    DynamicImage::from(image).into_rgba8()
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
    let mut leaves = rgba(foliage.color);
    for (pixel, mask) in leaves.pixels_mut().zip(foliage.mask.pixels()) {
        pixel.0[3] = mask.0[0];
    }
    Arc::new(SceneMaterial {
        texture: Some(Arc::new(SceneTexture::new(leaves))),
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

//! Textures and colours of the arcade.

use std::sync::Arc;

use bevy::math::Vec3;
use image::{DynamicImage, RgbImage, RgbaImage};

use crate::{
    content,
    meshes::scene::{SceneMaterial, SceneTexture},
};

/// Side of the textures in pixels.
const SIZE: u32 = 256;
const SEED: u64 = 5;

/// The materials of the arcade.
pub(super) struct Materials {
    pub bricks: Arc<SceneMaterial>,
    pub tiles: Arc<SceneMaterial>,
    pub planks: Arc<SceneMaterial>,
    pub stone: Arc<SceneMaterial>,
    pub plaster: Arc<SceneMaterial>,
    pub marble: Arc<SceneMaterial>,
    pub red: Arc<SceneMaterial>,
    pub leaves: Arc<SceneMaterial>,
    pub sign: Arc<SceneMaterial>,
}

impl Materials {
    pub fn new() -> Self {
        let rock = content::noise(SIZE, SIZE, SEED).color;
        let foliage = content::foliage(SIZE, SIZE, SEED);
        let mut leaves = rgba(foliage.color);
        for (pixel, mask) in leaves.pixels_mut().zip(foliage.mask.pixels()) {
            pixel.0[3] = mask.0[0];
        }
        Self {
            bricks: textured(brightened(content::bricks(SIZE, SIZE, SEED).color, 1.5)),
            tiles: textured(tiles(&rock)),
            planks: textured(brightened(content::wood(SIZE, SIZE, SEED).color, 1.3)),
            stone: textured(brightened(rock, 1.5)),
            plaster: colored(Vec3::new(0.78, 0.74, 0.66)),
            marble: colored(Vec3::new(0.8, 0.8, 0.78)),
            red: colored(Vec3::new(0.6, 0.08, 0.06)),
            leaves: Arc::new(SceneMaterial {
                texture: Some(Arc::new(SceneTexture::new(leaves))),
                alpha_cutoff: Some(0.5),
                is_double_sided: true,
                ..SceneMaterial::default()
            }),
            sign: Arc::new(SceneMaterial {
                albedo: Vec3::ZERO,
                emission: Vec3::new(160.0, 60.0, 130.0),
                emissive_texture: Some(Arc::new(SceneTexture::new(sign()))),
                ..SceneMaterial::default()
            }),
        }
    }
}

fn colored(albedo: Vec3) -> Arc<SceneMaterial> {
    Arc::new(SceneMaterial {
        albedo,
        ..SceneMaterial::default()
    })
}

fn textured(image: RgbImage) -> Arc<SceneMaterial> {
    Arc::new(SceneMaterial {
        texture: Some(Arc::new(SceneTexture::new(rgba(image)))),
        ..SceneMaterial::default()
    })
}

fn rgba(image: RgbImage) -> RgbaImage {
    DynamicImage::from(image).into_rgba8()
}

/// Encoded levels times a factor.
fn brightened(mut image: RgbImage, factor: f32) -> RgbImage {
    for pixel in image.pixels_mut() {
        pixel.0 = pixel
            .0
            .map(|level| (f32::from(level) * factor).min(240.0) as u8);
    }
    image
}

/// Light and dark tiles with the grain of a rock, four in each direction.
fn tiles(rock: &RgbImage) -> RgbImage {
    const TILE: u32 = SIZE / 4;
    RgbImage::from_fn(SIZE, SIZE, |x, y| {
        let is_light = (x / TILE + y / TILE).is_multiple_of(2);
        let tint = if is_light {
            [225.0, 215.0, 195.0]
        } else {
            [130.0, 90.0, 75.0]
        };
        let grain = 0.85 + 0.3 * f32::from(rock.get_pixel(x, y).0[1]) / 255.0;
        image::Rgb(tint.map(|level: f32| (level * grain).min(240.0) as u8))
    })
}

/// Bright letters on a dim ground.
fn sign() -> RgbaImage {
    let letters = content::label("BEVY", 64);
    let mut image = RgbaImage::from_pixel(
        letters.width() + 32,
        letters.height(),
        image::Rgba([70, 70, 70, 255]),
    );
    for (x, y, pixel) in letters.enumerate_pixels() {
        let level = pixel.0[3].max(70);
        image.put_pixel(x + 16, y, image::Rgba([level, level, level, 255]));
    }
    image
}

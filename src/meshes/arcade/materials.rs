//! Textures and colours of the arcade.

use std::sync::Arc;

use bevy::math::Vec3;
use image::RgbImage;

use crate::{
    content,
    meshes::{
        materials::{SEED, SIZE, brightened, colored, leaves, sign, textured},
        scene::SceneMaterial,
    },
};

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
        Self {
            bricks: textured(brightened(content::bricks(SIZE, SIZE, SEED).color, 1.5)),
            tiles: textured(tiles(&rock)),
            planks: textured(brightened(content::wood(SIZE, SIZE, SEED).color, 1.3)),
            stone: textured(brightened(rock, 1.5)),
            plaster: colored(Vec3::new(0.78, 0.74, 0.66)),
            marble: colored(Vec3::new(0.8, 0.8, 0.78)),
            red: colored(Vec3::new(0.6, 0.08, 0.06)),
            leaves: leaves(),
            sign: sign("BEVY", Vec3::new(160.0, 60.0, 130.0)),
        }
    }
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

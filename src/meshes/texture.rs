//! Images that repeat.

use bevy::math::{Vec2, Vec4};
use image::RgbaImage;

/// A colour image that repeats in both directions.
#[derive(Clone, Debug)]
pub struct SceneTexture {
    /// Encoded in sRGB; alpha is linear.
    pub pixels: RgbaImage,
    /// The same, linear.
    texels: Vec<Vec4>,
}

impl SceneTexture {
    pub fn new(pixels: RgbaImage) -> Self {
        let texels = pixels.pixels().map(|pixel| {
            let [r, g, b, a] = pixel.0.map(|byte| f32::from(byte) / 255.0);
            let [r, g, b] = [r, g, b].map(linear);
            Vec4::new(r, g, b, a)
        });
        Self {
            texels: texels.collect(),
            pixels,
        }
    }

    /// The bilinearly interpolated texel, linear.
    pub fn sample(&self, uv: Vec2) -> Vec4 {
        let size = [self.pixels.width() as i32, self.pixels.height() as i32];
        let at = uv * Vec2::new(size[0] as f32, size[1] as f32) - 0.5;
        let (corner, part) = (at.floor(), at - at.floor());
        let texel = |dx: i32, dy: i32| {
            let x = (corner.x as i32 + dx).rem_euclid(size[0]);
            let y = (corner.y as i32 + dy).rem_euclid(size[1]);
            self.texels[(y * size[0] + x) as usize]
        };
        let row = |dy| texel(0, dy).lerp(texel(1, dy), part.x);
        row(0).lerp(row(1), part.y)
    }
}

/// The sRGB transfer function, from encoded to linear.
fn linear(encoded: f32) -> f32 {
    if encoded <= 0.04045 {
        encoded / 12.92
    } else {
        ((encoded + 0.055) / 1.055).powf(2.4)
    }
}

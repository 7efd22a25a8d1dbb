//! Rendering of surface descriptions to images.

use image::{GrayImage, RgbImage, RgbaImage};
use rayon::prelude::*;

use crate::content::texture::Color;

/// A set of textures of one surface, all of the same size.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Material {
    /// Base colour, sRGB-encoded.
    pub color: RgbImage,
    /// Tangent-space unit normal, `(n + 1) / 2` as 0 to 255 per axis: +X right, +Y up (the
    /// convention of OpenGL and glTF), +Z out of the surface.
    pub normal: RgbImage,
    /// Coverage, 0 to 255: the opacity of foliage, the ink of text; elsewhere what separates the
    /// surface from its gaps and so can serve as a height or occlusion map.
    pub mask: GrayImage,
}

impl Material {
    /// The colour with the mask as its alpha.
    pub fn masked_color(&self) -> RgbaImage {
        RgbaImage::from_fn(self.color.width(), self.color.height(), |x, y| {
            let [r, g, b] = self.color.get_pixel(x, y).0;
            image::Rgba([r, g, b, self.mask.get_pixel(x, y).0[0]])
        })
    }
}

/// A point of a surface.
#[derive(Clone, Copy, Default)]
pub(super) struct Sample {
    pub color: Color,
    /// Height in units, positive out of the surface.
    pub height: f32,
    /// Coverage, 0 to 1.
    pub mask: f32,
}

/// How a surface continues beyond its border.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Border {
    /// It repeats.
    Wrap,
    /// It ends: heights there extend those at the border.
    Clamp,
}

/// Size of an image in units: the short side is one unit, the long one a whole number of them, so
/// that tiles repeat and yet are hardly stretched.
pub(super) fn units(width: u32, height: u32) -> [i32; 2] {
    let short = width.min(height).max(1) as f32;
    [width, height].map(|side| (side as f32 / short).round().max(1.0) as i32)
}

/// Renders the surface `sample(point)`, where `point` runs over [`units`] from the top left.
pub(super) fn render(
    width: u32,
    height: u32,
    border: Border,
    sample: impl Fn([f32; 2]) -> Sample + Sync,
) -> Material {
    // Four samples a pixel, enough to keep edges from looking like stairs.
    const OFFSETS: [f32; 2] = [0.25, 0.75];
    let units = units(width, height).map(|units| units as f32);
    let samples: Vec<Sample> = (0..height)
        .into_par_iter()
        .flat_map_iter(|y| (0..width).map(move |x| (x, y)))
        .map(|(x, y)| {
            let mut mean = Sample::default();
            for (dx, dy) in OFFSETS.iter().flat_map(|dy| OFFSETS.map(|dx| (dx, dy))) {
                let s = sample([
                    (x as f32 + dx) / width as f32 * units[0],
                    (y as f32 + dy) / height as f32 * units[1],
                ]);
                mean.color = [0, 1, 2].map(|c| mean.color[c] + s.color[c].clamp(0.0, 1.0) / 4.0);
                mean.height += s.height / 4.0;
                mean.mask += s.mask.clamp(0.0, 1.0) / 4.0;
            }
            mean
        })
        .collect();
    assemble(width, height, border, &samples)
}

/// Encodes samples, given one a pixel in raster order.
pub(super) fn assemble(width: u32, height: u32, border: Border, samples: &[Sample]) -> Material {
    let at = |x: i64, y: i64| {
        let (w, h) = (i64::from(width), i64::from(height));
        let (x, y) = match border {
            Border::Wrap => (x.rem_euclid(w), y.rem_euclid(h)),
            Border::Clamp => (x.clamp(0, w - 1), y.clamp(0, h - 1)),
        };
        &samples[(y * w + x) as usize]
    };
    let units = units(width, height);
    let pixels_per_unit = [
        width as f32 / units[0] as f32,
        height as f32 / units[1] as f32,
    ];
    Material {
        color: RgbImage::from_fn(width, height, |x, y| {
            image::Rgb(at(x.into(), y.into()).color.map(byte))
        }),
        normal: RgbImage::from_fn(width, height, |x, y| {
            let (x, y) = (i64::from(x), i64::from(y));
            let slope_x = (at(x + 1, y).height - at(x - 1, y).height) / 2.0 * pixels_per_unit[0];
            // Rows run down, +Y up.
            let slope_y = (at(x, y - 1).height - at(x, y + 1).height) / 2.0 * pixels_per_unit[1];
            let length = (slope_x * slope_x + slope_y * slope_y + 1.0).sqrt();
            image::Rgb([-slope_x, -slope_y, 1.0].map(|n| byte(n / length * 0.5 + 0.5)))
        }),
        mask: GrayImage::from_fn(width, height, |x, y| {
            image::Luma([byte(at(x.into(), y.into()).mask)])
        }),
    }
}

/// Quantises 0 to 1; values outside saturate.
pub(super) fn byte(value: f32) -> u8 {
    (value * 255.0).round() as u8
}

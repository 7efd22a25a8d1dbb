//! The input of the encoder.

use rayon::prelude::*;

use super::{
    color::{linear_from_srgb, srgb_from_linear},
    image::ColorSpace,
    layout,
    plane::next_mip_of,
};

/// Pixels of one mip level, row by row from the top.
#[derive(Clone, Copy, Debug)]
pub enum Pixels<'a> {
    /// One channel of 8 bits.
    Gray8(&'a [u8]),
    /// One channel of 16 bits.
    Gray16(&'a [u16]),
    /// RGB, 8 bits a channel.
    Rgb8(&'a [[u8; 3]]),
    /// RGBA, 8 bits a channel, with straight (not premultiplied) alpha.
    Rgba8(&'a [[u8; 4]]),
    /// RGBA, 16 bits a channel, with straight (not premultiplied) alpha.
    Rgba16(&'a [[u16; 4]]),
}

impl Pixels<'_> {
    /// Number of pixels.
    pub fn len(&self) -> usize {
        match self {
            Self::Gray8(pixels) => pixels.len(),
            Self::Gray16(pixels) => pixels.len(),
            Self::Rgb8(pixels) => pixels.len(),
            Self::Rgba8(pixels) => pixels.len(),
            Self::Rgba16(pixels) => pixels.len(),
        }
    }

    /// Returns whether there are no pixels.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns whether a channel has 16 bits.
    fn is_wide(&self) -> bool {
        matches!(self, Self::Gray16(_) | Self::Rgba16(_))
    }

    /// RGBA of the pixel at index `i`, each channel in `[0, 1]`.
    #[inline]
    pub fn get(&self, i: usize) -> [f32; 4] {
        let byte = |v: u8| f32::from(v) / 255.0;
        let word = |v: u16| f32::from(v) / 65535.0;
        match self {
            Self::Gray8(pixels) => {
                let v = byte(pixels[i]);
                [v, v, v, 1.0]
            }
            Self::Gray16(pixels) => {
                let v = word(pixels[i]);
                [v, v, v, 1.0]
            }
            Self::Rgb8(pixels) => {
                let [r, g, b] = pixels[i].map(byte);
                [r, g, b, 1.0]
            }
            Self::Rgba8(pixels) => pixels[i].map(byte),
            Self::Rgba16(pixels) => pixels[i].map(word),
        }
    }

    /// A channel of the pixel at index `i`, in `[0, 1]`.
    #[inline]
    pub(super) fn channel(&self, i: usize, c: usize) -> f32 {
        match self {
            Self::Rgb8(pixels) if c < 3 => f32::from(pixels[i][c]) / 255.0,
            Self::Rgba8(pixels) => f32::from(pixels[i][c]) / 255.0,
            Self::Rgba16(pixels) => f32::from(pixels[i][c]) / 65535.0,
            _ => self.get(i)[c],
        }
    }
}

/// An image to encode.
#[derive(Clone, Debug)]
pub struct Source<'a> {
    /// Width and height of the first level, in pixels.
    pub size: [u32; 2],
    /// The pixels of the image and, optionally, of its mips from the largest, each of half the size
    /// of the one before, rounded down. Given mips are encoded without filtering them again.
    pub levels: Vec<Pixels<'a>>,
}

impl<'a> Source<'a> {
    /// An image without mips.
    pub fn new(size: [u32; 2], pixels: Pixels<'a>) -> Self {
        Self {
            size,
            levels: vec![pixels],
        }
    }
}

/// Added to the alpha by which colours are weighted, so that pixels that are all transparent keep their
/// colour.
pub(super) const LEAST_WEIGHT: f32 = 1.0 / 4096.0;

/// RGBA of one mip level in linear light, filtered from the level before and weighted by alpha, so that the
/// colour of transparent pixels does not bleed.
pub(super) struct LinearLevel {
    pub(super) size: [u32; 2],
    pixels: Vec<[f32; 4]>,
}

impl LinearLevel {
    /// The first mip below a level, which is converted as it is filtered.
    pub(super) fn below(
        pixels: &Pixels<'_>,
        size: [u32; 2],
        color_space: ColorSpace,
        alpha: bool,
    ) -> Self {
        // 8 bits have few values, so all are computed once.
        let bytes: Vec<f32> = (0..256)
            .map(|v| linear_from_srgb(v as f32 / 255.0))
            .collect();
        let is_wide = pixels.is_wide();
        let linear = |v: f32| match color_space {
            ColorSpace::Linear => v,
            ColorSpace::Srgb if is_wide => linear_from_srgb(v),
            ColorSpace::Srgb => bytes[(v * 255.0 + 0.5) as usize],
        };
        let value = |i: usize| {
            let [r, g, b, a] = pixels.get(i);
            let weight = if alpha { a + LEAST_WEIGHT } else { 1.0 };
            let [r, g, b] = [r, g, b].map(|v| weight * linear(v));
            [r, g, b, a]
        };
        let (size, pixels) = next_mip_of(size, value);
        Self { size, pixels }
    }

    /// The next mip.
    pub(super) fn next(&self) -> Self {
        let (size, pixels) = next_mip_of(self.size, |i| self.pixels[i]);
        Self { size, pixels }
    }

    /// RGBA of all pixels in 16 bits, encoded in a colour space again, with straight alpha.
    pub(super) fn encoded(&self, color_space: ColorSpace, alpha: bool) -> Vec<[u16; 4]> {
        let word = |v: f32| (v.clamp(0.0, 1.0) * 65535.0 + 0.5) as u16;
        let encoded = |&[r, g, b, a]: &[f32; 4]| {
            let scale = if alpha { 1.0 / (a + LEAST_WEIGHT) } else { 1.0 };
            let color = |linear: f32| match color_space {
                ColorSpace::Srgb => word(srgb_from_linear((linear * scale).min(1.0))),
                ColorSpace::Linear => word(linear * scale),
            };
            [color(r), color(g), color(b), word(a)]
        };
        self.pixels.par_iter().map(encoded).collect()
    }
}

/// Number of pixels of a mip level of [`Source::levels`].
pub(super) fn level_pixels(size: [u32; 2], level: usize) -> u64 {
    let [width, height] = layout::mip_size(size, level as u32);
    u64::from(width) * u64::from(height)
}

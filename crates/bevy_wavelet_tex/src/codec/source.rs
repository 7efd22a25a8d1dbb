//! The input of the encoder.

use super::{color::linear_from_srgb, image::ColorSpace, layout, plane::Plane};

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

    /// RGBA of the pixel at index `i`, each channel in `[0, 1]`.
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

/// The four channels at one mip level, filtered from those of the level before, in linear light and
/// weighted by alpha, so that the colour of transparent pixels does not bleed.
pub(super) struct LinearLevel {
    channels: [Plane; 4],
}

impl LinearLevel {
    /// The first mip below a level. It does not convert the whole level at once, which would take a
    /// copy.
    pub(super) fn below(
        pixels: &Pixels<'_>,
        size: [u32; 2],
        color_space: ColorSpace,
        alpha: bool,
    ) -> Self {
        let channel = |c: usize| {
            let value = |i: usize| {
                let pixel = pixels.get(i);
                let a = if alpha { pixel[3] + LEAST_WEIGHT } else { 1.0 };
                match c {
                    3 => pixel[3],
                    _ if color_space == ColorSpace::Srgb => a * linear_from_srgb(pixel[c]),
                    _ => a * pixel[c],
                }
            };
            Plane::next_mip_of(size, value)
        };
        Self {
            channels: [channel(0), channel(1), channel(2), channel(3)],
        }
    }

    /// The next mip.
    pub(super) fn next(&self) -> Self {
        Self {
            channels: [0, 1, 2, 3].map(|c: usize| self.channels[c].next_mip()),
        }
    }

    /// The alpha of all pixels.
    pub(super) fn alpha(&self) -> &[f32] {
        &self.channels[3].values
    }

    /// The red of all pixels, in linear light.
    pub(super) fn red(&self) -> &[f32] {
        &self.channels[0].values
    }

    /// RGBA of a pixel, encoded in its colour space again, with straight alpha.
    pub(super) fn get(&self, i: usize, color_space: ColorSpace, alpha: bool) -> [f32; 4] {
        let a = self.channels[3].values[i];
        let scale = if alpha { 1.0 / (a + LEAST_WEIGHT) } else { 1.0 };
        let color = |c: usize| {
            let linear = self.channels[c].values[i] * scale;
            match color_space {
                ColorSpace::Srgb => super::color::srgb_from_linear(linear.min(1.0)),
                ColorSpace::Linear => linear,
            }
        };
        [color(0), color(1), color(2), a]
    }
}

/// Number of pixels of a mip level of [`Source::levels`].
pub(super) fn level_pixels(size: [u32; 2], level: usize) -> u64 {
    let [width, height] = layout::mip_size(size, level as u32);
    u64::from(width) * u64::from(height)
}

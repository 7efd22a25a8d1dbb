//! The input of the encoder, its mips, and the planes of a content.

use rayon::prelude::*;

use super::{
    axes::ColorAxes,
    color::{linear_from_srgb, srgb_from_linear},
    image::{ColorSpace, Content},
    layout,
    plane::{Plane, next_mip_of},
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

    /// Some of the pixels.
    #[cfg(feature = "bevy")]
    pub(crate) fn part(self, range: std::ops::Range<usize>) -> Self {
        match self {
            Self::Gray8(pixels) => Self::Gray8(&pixels[range]),
            Self::Gray16(pixels) => Self::Gray16(&pixels[range]),
            Self::Rgb8(pixels) => Self::Rgb8(&pixels[range]),
            Self::Rgba8(pixels) => Self::Rgba8(&pixels[range]),
            Self::Rgba16(pixels) => Self::Rgba16(&pixels[range]),
        }
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

/// [`Pixels`] that are made of others.
pub(crate) enum OwnedPixels {
    Gray8(Vec<u8>),
    Gray16(Vec<u16>),
    Rgba8(Vec<[u8; 4]>),
    Rgba16(Vec<[u16; 4]>),
}

impl OwnedPixels {
    pub(crate) fn pixels(&self) -> Pixels<'_> {
        match self {
            Self::Gray8(pixels) => Pixels::Gray8(pixels),
            Self::Gray16(pixels) => Pixels::Gray16(pixels),
            Self::Rgba8(pixels) => Pixels::Rgba8(pixels),
            Self::Rgba16(pixels) => Pixels::Rgba16(pixels),
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

/// The pixels of one mip level, from which its planes are made where they are needed: all planes together would
/// take several times the memory of the pixels.
#[derive(Clone, Copy)]
pub(super) struct LevelPlanes<'a> {
    pub(super) size: [u32; 2],
    pixels: Pixels<'a>,
    pub(super) content: Content,
    /// The weights of R, G and B in luma and in each plane of chroma.
    weights: [[f32; 3]; 3],
}

impl<'a> LevelPlanes<'a> {
    pub(super) fn new(
        pixels: Pixels<'a>,
        size: [u32; 2],
        content: Content,
        axes: ColorAxes,
    ) -> Self {
        Self {
            size,
            pixels,
            content,
            weights: axes.weights(),
        }
    }

    /// The levels of a source.
    pub(super) fn of(source: &Source<'a>, content: Content, axes: ColorAxes) -> Vec<Self> {
        let level = |(level, pixels): (usize, &Pixels<'a>)| {
            let size = layout::mip_size(source.size, level as u32);
            Self::new(*pixels, size, content, axes)
        };
        source.levels.iter().enumerate().map(level).collect()
    }

    /// A plane of the luma group: luma (then alpha), gray, or X and Y of normals.
    pub(super) fn luma(&self, plane: usize) -> Plane {
        let values = 0..self.pixels.len();
        let values = values.into_par_iter().map(|i| {
            let pixel = self.pixels.get(i);
            match (self.content, plane) {
                (Content::Normal, plane) => unit(pixel)[plane],
                (Content::ColorAlpha, 1) => pixel[3],
                _ => self.along(0, pixel),
            }
        });
        Plane {
            size: self.size,
            values: values.collect(),
        }
    }

    /// A pixel of a plane of chroma.
    pub(super) fn chroma(&self, plane: usize, i: usize) -> f32 {
        self.along(1 + plane, self.pixels.get(i))
    }

    fn along(&self, axis: usize, pixel: [f32; 4]) -> f32 {
        let [r, g, b] = self.weights[axis];
        r * pixel[0] + g * pixel[1] + b * pixel[2]
    }
}

/// The normal that a pixel stands for. The zero vector has no direction and becomes +Z.
pub(super) fn unit([x, y, z, _]: [f32; 4]) -> [f32; 3] {
    let v = [x, y, z].map(|v| 2.0 * v - 1.0);
    let length = v.iter().map(|v| v * v).sum::<f32>().sqrt();
    if length > 1e-6 {
        v.map(|v| v / length)
    } else {
        [0.0, 0.0, 1.0]
    }
}

/// Downsampling of images to a size limit.
pub mod reduce {
    use super::{ColorSpace, LEAST_WEIGHT, linear_from_srgb, next_mip_of, srgb_from_linear};

    /// Halves an image until no side is longer than `most` pixels, and returns its size and its RGBA
    /// pixels of 8 bits. It is filtered by the box filter that makes mips; sRGB colours are filtered in linear
    /// light and weighted by their alpha. `pixel` returns RGBA in `[0, 1]`.
    pub fn reduced_rgba8(
        size: [u32; 2],
        pixel: impl Fn(usize) -> [f32; 4] + Sync,
        most: u32,
        color_space: ColorSpace,
    ) -> ([u32; 2], Vec<[u8; 4]>) {
        let is_srgb = color_space == ColorSpace::Srgb;
        let linear = |i: usize| {
            let [r, g, b, alpha] = pixel(i);
            if !is_srgb {
                return [r, g, b, alpha];
            }
            let [r, g, b] = [r, g, b].map(|v| linear_from_srgb(v) * (alpha + LEAST_WEIGHT));
            [r, g, b, alpha]
        };
        let is_too_large = |size: [u32; 2], most: u32| size.iter().any(|s| *s > most);
        let (mut size, mut pixels) = if is_too_large(size, most) {
            next_mip_of(size, linear)
        } else {
            let count = size[0] as usize * size[1] as usize;
            (size, (0..count).map(linear).collect())
        };
        while is_too_large(size, most.max(1)) {
            (size, pixels) = next_mip_of(size, |i| pixels[i]);
        }
        let byte = |v: f32| (v.clamp(0.0, 1.0) * 255.0).round() as u8;
        let encoded = |[r, g, b, alpha]: [f32; 4]| {
            let color = |v: f32| match is_srgb {
                true => byte(srgb_from_linear(v / (alpha + LEAST_WEIGHT))),
                false => byte(v),
            };
            [color(r), color(g), color(b), byte(alpha)]
        };
        (size, pixels.into_iter().map(encoded).collect())
    }

    #[cfg(test)]
    mod tests {
        use super::*;

        #[test]
        fn transparent_pixels_give_no_colour_to_others() {
            // Columns of opaque red and of transparent green.
            let striped = |i: usize| {
                if i.is_multiple_of(2) {
                    [1.0, 0.0, 0.0, 1.0]
                } else {
                    [0.0, 1.0, 0.0, 0.0]
                }
            };
            let (_, pixels) = reduced_rgba8([8, 8], striped, 4, ColorSpace::Srgb);
            assert!(
                pixels
                    .iter()
                    .all(|p| p[0] == 255 && p[1] < 16 && p[3] == 128),
                "{pixels:?}"
            );
            let clear = |_| [0.2, 0.4, 0.6, 0.0];
            let (_, pixels) = reduced_rgba8([8, 8], clear, 4, ColorSpace::Srgb);
            assert!(pixels.iter().all(|p| *p == [51, 102, 153, 0]), "{pixels:?}");
        }

        #[test]
        fn sides_are_halved_until_they_fit() {
            let flat = |_| [0.2, 0.4, 0.6, 0.8];
            for (size, most, expected) in [
                ([64, 48], 20, [16, 12]),
                ([7, 100], 30, [1, 25]),
                ([5, 5], 5, [5, 5]),
                ([3, 1], 1, [1, 1]),
            ] {
                for space in [ColorSpace::Srgb, ColorSpace::Linear] {
                    let (actual, pixels) = reduced_rgba8(size, flat, most, space);
                    assert_eq!(actual, expected);
                    assert!(pixels.iter().all(|p| *p == [51, 102, 153, 204]));
                }
            }
        }
    }
}

//! The choice between a wavelet and plain textures of the same bits, by their errors: of those that are not encoded yet,
//! from a part of their pixels.

use std::ops::Range;

use rayon::prelude::*;

use super::{
    PlainTexture,
    encode::{Channels, add_level, blocks, fitted_texels},
    mix,
};
use crate::codec::{
    blocks::{BlockFormat, decode_blocks},
    image::{Content, Payload, WaveletImage},
    interpolation::Tap,
    layout,
    plane::Plane,
    quality::{Errors, Window, level_weight, pixel_error},
    settings::{Effort, EncodeSettings},
    source::Source,
};

/// A texture is encoded where its error in the windows, before it is refined by pixels, is at most this factor of that
/// of the wavelet.
const DOUBT: f64 = 1.08;

/// Textures of no more blocks are encoded without an estimate: those of 192 x 192 texels.
const LEAST_BLOCKS: u32 = 2304;

/// Textures of no more blocks, those of sprites, are worth the best effort.
const FEW_BLOCKS: u32 = 256;

/// The format and the size of the largest level of a plain texture.
#[derive(Clone, Copy)]
struct Candidate {
    format: BlockFormat,
    size: [u32; 2],
}

/// The plain texture that has the least error over all levels, of all formats and sizes, where its mean squared error in
/// 8-bit units is less than that of the errors `least`, if there are any. `windows` are those of each level, and `bytes`
/// are the most that its first level may take.
pub(in crate::codec) fn better(
    source: &Source<'_>,
    content: Content,
    least: Option<Errors>,
    windows: &[Vec<Window>],
    settings: &EncodeSettings,
    bytes: usize,
) -> Option<WaveletImage> {
    let levels: Vec<Channels<'_>> = (0..)
        .zip(&source.levels)
        .map(|(level, pixels)| Channels {
            size: layout::mip_size(source.size, level),
            pixels: *pixels,
            content,
        })
        .collect();
    let full = PlainTexture::full_size(source.size);
    let blocks = full[0] / 4 * (full[1] / 4);
    let effort = match settings.effort {
        Effort::Default if blocks <= FEW_BLOCKS => Effort::Best,
        effort => effort,
    };
    let encoded = |candidate: Candidate| {
        let mut plain = candidate.empty();
        let count = candidate.levels(source);
        for (level, channels) in levels.iter().enumerate().take(count) {
            add_level(&mut plain, level as u32, source.size, channels, effort);
        }
        let image = WaveletImage {
            content,
            color_space: settings.stored_color_space(),
            size: source.size,
            levels: count as u32,
            payload: Payload::Plain(plain),
        };
        (Errors::of(source, &image, windows).all, image)
    };
    let mut most = least.map_or(f64::INFINITY, |errors| DOUBT * errors.in_windows);
    let mut least = least.map_or(f64::INFINITY, |errors| errors.all);
    let mut best = None;
    let mut promising = None;
    for &format in PlainTexture::formats(content) {
        for size in PlainTexture::sizes_within(source.size, format, bytes) {
            let candidate = Candidate { format, size };
            if blocks <= LEAST_BLOCKS || settings.effort == Effort::Best {
                let (mse, image) = encoded(candidate);
                if mse < least {
                    (least, best) = (mse, Some(image));
                }
            } else if let Some(error) =
                candidate.estimated_error(source, &levels, windows, most, settings.effort)
            {
                (most, promising) = (error, Some(candidate));
            }
        }
    }
    if let Some(candidate) = promising {
        let (mse, image) = encoded(candidate);
        if mse < least {
            best = Some(image);
        }
    }
    best
}

impl Candidate {
    fn empty(self) -> PlainTexture {
        PlainTexture {
            format: self.format,
            size: self.size,
            blocks: Vec::new(),
        }
    }

    /// Number of levels of a source that it has.
    fn levels(self, source: &Source<'_>) -> usize {
        let most = PlainTexture::max_level_count(self.size, source.size);
        source.levels.len().min(most as usize)
    }

    /// The mean squared error of the windows of all levels, by how much these are used, where it is less than `most`.
    fn estimated_error(
        self,
        source: &Source<'_>,
        levels: &[Channels<'_>],
        windows: &[Vec<Window>],
        most: f64,
        effort: Effort,
    ) -> Option<f64> {
        let count = self.levels(source);
        let is_scaled = self.empty().is_scaled(source.size);
        let total: f64 = (0..count).map(level_weight).sum();
        let mut sum = 0.0;
        let levels = levels.iter().zip(windows).take(count);
        for (level, (channels, windows)) in levels.enumerate() {
            let part = level_weight(level) / total;
            let size = layout::mip_size(self.size, level as u32);
            let estimate = LevelEstimate::new(channels, self.format, size, is_scaled, windows);
            if is_scaled && sum + part * estimate.error_of_size() >= most {
                return None;
            }
            sum += part * estimate.error(effort);
            if sum >= most {
                return None;
            }
        }
        Some(sum)
    }
}

/// Texels around a window whose pixels decide with its own which texels fit best: each has a third of the influence of
/// the one before.
const MARGIN: u32 = 6;

/// The texels between which the pixels of a window lie, in whole blocks.
struct Part<'a> {
    window: &'a Window,
    /// The first texel.
    corner: [u32; 2],
    /// A plane for each channel.
    texels: Vec<Plane>,
}

/// A level of a texture that is not encoded yet.
struct LevelEstimate<'a> {
    format: BlockFormat,
    /// The channels of the image.
    channels: &'a Channels<'a>,
    /// The two texels between which each pixel of a row, and of a column, lies.
    taps: [Vec<Tap>; 2],
    parts: Vec<Part<'a>>,
}

impl<'a> LevelEstimate<'a> {
    /// Fits the texels of the windows of a level to the channels of an image.
    fn new(
        channels: &'a Channels<'a>,
        format: BlockFormat,
        size: [u32; 2],
        is_scaled: bool,
        windows: &'a [Window],
    ) -> Self {
        let taps = PlainTexture::axes(channels.size, size, is_scaled).map(|axis| axis.all_taps());
        let part = |window: &'a Window| {
            let range = |axis: usize| {
                let taps =
                    &taps[axis][window.corner[axis] as usize..][..window.size[axis] as usize];
                let (first, last) = (taps[0].0, taps[taps.len() - 1].1);
                first / 4 * 4..(last + 1).next_multiple_of(4).min(size[axis])
            };
            let inner = [range(0), range(1)];
            let outer = [0, 1].map(|axis: usize| match is_scaled {
                true => {
                    let Range { start, end } = inner[axis];
                    start.saturating_sub(MARGIN)..(end + MARGIN).min(size[axis])
                }
                false => inner[axis].clone(),
            });
            let fitted = fitted_texels(channels, &taps, &outer, is_scaled);
            let [columns, rows] = inner.each_ref().map(|range| range.end - range.start);
            let [left, top] = [0, 1].map(|axis: usize| inner[axis].start - outer[axis].start);
            let cut = |plane: Plane| {
                let at = |x, y| plane.clamped(left + x, top + y);
                Plane::from_fn([columns, rows], at)
            };
            Part {
                window,
                corner: inner.map(|range| range.start),
                texels: fitted.into_iter().map(cut).collect(),
            }
        };
        let parts = windows.par_iter().map(part).collect();
        Self {
            format,
            channels,
            taps,
            parts,
        }
    }

    /// Mean squared error of the pixels in 8-bit units, where the texels are read without being encoded.
    fn error_of_size(&self) -> f64 {
        self.mean_error(|part| {
            let texels = 0..part.texels[0].values.len();
            texels.map(|i| texel(&part.texels, i)).collect()
        })
    }

    /// The same with encoded texels.
    fn error(&self, effort: Effort) -> f64 {
        self.mean_error(|part| {
            let size = part.texels[0].size;
            let blocks = blocks(self.format, &part.texels, size, effort);
            decode_blocks(self.format, &blocks, size)
        })
    }

    fn mean_error(&self, read: impl Fn(&Part<'_>) -> Vec<[f32; 4]> + Sync) -> f64 {
        let of_part = |part: &Part<'_>| self.sum_of_errors(part, &read(part));
        let sums: Vec<u64> = self.parts.par_iter().map(of_part).collect();
        let pixels: usize = self.parts.iter().map(|part| part.window.pixels()).sum();
        sums.iter().sum::<u64>() as f64 / (pixels * self.channels.content.error_channels()) as f64
    }

    fn sum_of_errors(&self, part: &Part<'_>, texels: &[[f32; 4]]) -> u64 {
        let [left, top] = part.window.corner;
        let [columns, rows] = part.window.size;
        let width = part.texels[0].size[0] as usize;
        let content = self.channels.content;
        let row = |y: u32| -> u64 {
            let (above, below, v) = self.taps[1][y as usize];
            let line = |y: u32| texels[(y - part.corner[1]) as usize * width..][..width].iter();
            let pairs = line(above).zip(line(below));
            let blended: Vec<[f32; 4]> = pairs.map(|(a, b)| mix(*a, *b, v)).collect();
            let start = y as usize * self.channels.size[0] as usize;
            let pixel = |x: u32| {
                let (first, second, u) = self.taps[0][x as usize];
                let [a, b] = [first, second].map(|x| blended[(x - part.corner[0]) as usize]);
                let expected = self.channels.pixels.get(start + x as usize);
                let read = content.of_channels(mix(a, b, u));
                u64::from(pixel_error(content, expected, read))
            };
            (left..left + columns).map(pixel).sum()
        };
        (top..top + rows).map(row).sum()
    }
}

/// All channels of a texel. Those that are missing are 1.
fn texel(planes: &[Plane], i: usize) -> [f32; 4] {
    std::array::from_fn(|c| planes.get(c).map_or(1.0, |plane| plane.values[i]))
}

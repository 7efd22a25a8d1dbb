//! Encoding with values beyond black and white, which decoders clamp.
//!
//! Where a channel of a pixel is black or white, whatever is decoded beyond it is no error, so that blocks with such
//! pixels have more ways to store the others. A pixel that came out beyond is wanted there, and somewhat further, in the
//! next round.

use rayon::prelude::*;

use super::{
    blocks::decode_blocks,
    choice::Choice,
    decoder::LevelRows,
    image::{Content, WaveletImage},
    layout,
    planes::LevelPlanes,
    quality::Errors,
    settings::Effort,
    source::{Pixels, Source},
    windows::Window,
};

/// The least part of the squared error that a round has to save for the same to be done again.
const LEAST_GAIN: f64 = 0.005;

/// RGBA in units of [`ONE`], which may be below 0 and above 1.
type WidePixel = [i16; 4];

const ONE: f32 = 8192.0;

/// The pixels that are wanted of a level, some of them beyond black and white.
#[derive(Clone, Copy, Debug)]
pub(super) enum Wanted<'a> {
    Given(Pixels<'a>),
    Wide(&'a [WidePixel]),
}

impl Wanted<'_> {
    pub(super) fn len(&self) -> usize {
        match self {
            Self::Given(pixels) => pixels.len(),
            Self::Wide(pixels) => pixels.len(),
        }
    }

    #[inline]
    pub(super) fn get(&self, i: usize) -> [f32; 4] {
        match self {
            Self::Given(pixels) => pixels.get(i),
            Self::Wide(pixels) => pixels[i].map(|v| f32::from(v) / ONE),
        }
    }
}

/// A way to encode an image again.
#[derive(Clone, Copy)]
struct Round {
    /// How much further a value is wanted than it came out.
    further: f32,
    /// Whether chroma and all parameters are sought anew, or luma is encoded with those that it has.
    is_whole: bool,
}

const WHOLE: Round = Round {
    further: 1.0,
    is_whole: true,
};
const LUMA: Round = Round {
    further: 1.0,
    is_whole: false,
};
const LUMA_AS_IT_IS: Round = Round {
    further: 0.0,
    is_whole: false,
};

/// Encodes a wavelet again as long as that reduces its error.
pub(super) fn improve(
    choice: &mut Choice<'_>,
    errors: &mut Errors,
    source: &Source<'_>,
    windows: &[Vec<Window>],
) {
    // The least part beyond black and white for which rounds are worth their time, and how many there are.
    let (least_part, kinds) = match choice.job.settings.effort {
        Effort::Fast => return,
        Effort::Default => (0.05, [(WHOLE, 3), (LUMA, 1), (LUMA_AS_IT_IS, 1)]),
        Effort::Best => (0.01, [(WHOLE, 6), (LUMA, 4), (LUMA_AS_IT_IS, 4)]),
    };
    let image = &choice.image;
    if image.content == Content::Normal || part_beyond(image, source) < least_part {
        return;
    }
    for (round, times) in kinds {
        for _ in 0..times {
            let next = again(choice, source, round);
            let found = Errors::of(source, &next, windows);
            let gain = 1.0 - found.all / errors.all;
            if gain > 0.0 {
                (choice.image, *errors) = (next, found);
            }
            if gain < LEAST_GAIN {
                break;
            }
        }
    }
}

/// How far free values of the largest level lie beyond black and white, as a part of its squared error.
fn part_beyond(image: &WaveletImage, source: &Source<'_>) -> f64 {
    let rows = LevelRows::new(image, 0, decode_blocks);
    let width = rows.size[0] as usize;
    let channels = image.content.error_channels();
    let of_row = |row: &mut Vec<[f32; 4]>, y: u32| {
        rows.fill_unclamped(y, row);
        let [mut beyond, mut error] = [0.0; 2];
        for (x, decoded) in row.iter().enumerate() {
            let expected = source.levels[0].get(y as usize * width + x);
            for (decoded, expected) in decoded.iter().zip(expected).take(channels) {
                let clamped = decoded.clamp(0.0, 1.0);
                error += f64::from((clamped - expected).powi(2));
                if clamped == expected {
                    beyond += f64::from((decoded - clamped).powi(2));
                }
            }
        }
        [beyond, error]
    };
    let row = || vec![[0.0; 4]; width];
    let rows = (0..rows.size[1]).into_par_iter().map_init(row, of_row);
    let sums: Vec<[f64; 2]> = rows.collect();
    let [beyond, error] = [0, 1].map(|i: usize| sums.iter().map(|sums| sums[i]).sum::<f64>());
    beyond / error.max(f64::MIN_POSITIVE)
}

fn again(choice: &Choice<'_>, source: &Source<'_>, round: Round) -> WaveletImage {
    let Choice { job, image } = choice;
    let wide: Vec<Vec<WidePixel>> = (0..image.levels)
        .map(|level| wide_pixels(image, source, level, round.further))
        .collect();
    let levels = wide.iter().enumerate().map(|(level, pixels)| {
        let size = layout::mip_size(image.size, level as u32);
        LevelPlanes::new(Wanted::Wide(pixels), size, image.content, job.axes)
    });
    let levels: Vec<LevelPlanes<'_>> = levels.collect();
    if round.is_whole {
        job.image(&levels, image.color_space)
    } else {
        job.with_luma(image, &levels)
    }
}

fn wide_pixels(
    image: &WaveletImage,
    source: &Source<'_>,
    level: u32,
    further: f32,
) -> Vec<WidePixel> {
    let rows = LevelRows::new(image, level, decode_blocks);
    let pixels = source.levels[level as usize];
    let width = rows.size[0] as usize;
    let wanted = |expected: f32, decoded: f32| {
        let is_free = expected <= 0.0 && decoded < 0.0 || expected >= 1.0 && decoded > 1.0;
        match is_free {
            true => decoded + further * (decoded - expected),
            false => expected,
        }
    };
    let mut wide = vec![[0; 4]; pixels.len()];
    let lines = wide.par_chunks_mut(width).enumerate();
    lines.for_each_init(
        || vec![[0.0; 4]; width],
        |row, (y, wide)| {
            rows.fill_unclamped(y as u32, row);
            for (x, (wide, decoded)) in wide.iter_mut().zip(row).enumerate() {
                let expected = pixels.get(y * width + x);
                *wide =
                    std::array::from_fn(|c| (wanted(expected[c], decoded[c]) * ONE).round() as i16);
            }
        },
    );
    wide
}

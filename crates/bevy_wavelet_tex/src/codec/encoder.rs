//! The encoder: from pixels to a [`WaveletImage`].

use thiserror::Error;

use super::{
    choice::{Choice, choose},
    decoder::decode,
    image::WaveletImage,
    layout,
    prepare::Prepared,
    quality,
    rate::Rate,
    settings::EncodeSettings,
    source::{Pixels, Source, level_pixels},
};

/// Encodes an image.
///
/// Gray is the luma of YCoCg, as in the thesis; normals are X and Y of the unit vector. The result
/// does not depend on the number of threads. `progress` is called after each part with the number
/// of finished parts and their total: the mips are made, and the image is encoded.
///
/// # Errors
/// Returns an error when the size is out of range or does not match the number of pixels.
pub fn encode(
    source: &Source<'_>,
    settings: &EncodeSettings,
    progress: &(dyn Fn(usize, usize) + Sync),
) -> Result<WaveletImage, EncodeError> {
    check(source)?;
    let prepared = Prepared::new(source, settings);
    progress(1, 2);
    let source = &prepared.source();
    let content = settings.rate.content(settings.alpha);
    let choice = match settings.min_psnr_db {
        None => choose(source, settings, settings.rate),
        Some(min_psnr_db) => {
            // The PSNR of the largest level decides.
            let is_enough =
                |choice: &Choice<'_>| quality::psnr_db(source, &choice.image) >= min_psnr_db;
            let mut choices = Rate::of(content).map(|rate| choose(source, settings, rate));
            let mut choice = choices.next().expect("every content has a rate");
            while !is_enough(&choice)
                && let Some(next) = choices.next()
            {
                choice = next;
            }
            choice
        }
    };
    let image = with_coverage(choice, &prepared);
    progress(2, 2);
    Ok(image)
}

/// Encodes RGB pixels of 8 bits a channel, row by row from the top.
///
/// # Errors
/// Returns the errors of [`encode`].
pub fn encode_rgb8(
    pixels: &[[u8; 3]],
    size: [u32; 2],
    settings: &EncodeSettings,
) -> Result<WaveletImage, EncodeError> {
    encode(
        &Source::new(size, Pixels::Rgb8(pixels)),
        settings,
        &|_, _| {},
    )
}

/// The reason why an image cannot be encoded.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum EncodeError {
    /// A side of the image is 0 or larger than [`layout::MAX_SIZE`].
    #[error("an image of {} x {} pixels cannot be encoded: both sides must be 1 to {}", .0[0], .0[1], layout::MAX_SIZE)]
    Size([u32; 2]),
    /// A level does not have as many pixels as the size requires.
    #[error(
        "mip level {level} of an image of {} x {} pixels should have {expected} pixels, it has \
         {pixels}",
        .size[0], .size[1]
    )]
    PixelCount {
        /// Width and height of the image in pixels.
        size: [u32; 2],
        /// The mip level; 0 is the image itself.
        level: usize,
        /// Number of pixels that the level should have.
        expected: u64,
        /// Number of pixels that were given.
        pixels: usize,
    },
    /// The image has no mip level.
    #[error("an image without a mip level cannot be encoded")]
    NoLevel,
}

fn check(source: &Source<'_>) -> Result<(), EncodeError> {
    let size = source.size;
    if size.iter().any(|s| !(1..=layout::MAX_SIZE).contains(s)) {
        return Err(EncodeError::Size(size));
    }
    if source.levels.is_empty() {
        return Err(EncodeError::NoLevel);
    }
    for (level, pixels) in source.levels.iter().enumerate() {
        let expected = level_pixels(size, level);
        if pixels.len() as u64 != expected {
            return Err(EncodeError::PixelCount {
                size,
                level,
                expected,
                pixels: pixels.len(),
            });
        }
    }
    Ok(())
}

/// How far from the cutoff the alpha of all pixels of a level is kept, one after the other until its encoding moves
/// few enough over the cutoff.
const MARGINS: [f32; 5] = [0.02, 0.04, 0.08, 0.16, 0.3];

/// The image with mips that cover as much as the first level, where something is cut out.
fn with_coverage(choice: Choice<'_>, prepared: &Prepared<'_>) -> WaveletImage {
    let Choice { job, mut image } = choice;
    let Some(cut_out) = prepared.cut_out() else {
        return image;
    };
    let excess: Vec<f64> = (0..image.levels)
        .map(|level| cut_out.excess(&decode(&image, level)))
        .collect();
    let Some(first) = (1..image.levels).find(|level| excess[*level as usize] > 0.0) else {
        return image;
    };
    image.truncate(first);
    for level in first..image.levels {
        let pixels = prepared
            .made(level)
            .expect("mips are made for what is cut out");
        let mut best = (excess[level as usize], 0.0);
        let margins = MARGINS
            .into_iter()
            .take(if best.0 > 0.0 { MARGINS.len() } else { 0 });
        for margin in margins {
            let apart = cut_out.apart(pixels, margin);
            job.add_level(&mut image, level, Pixels::Rgba16(&apart));
            let excess = cut_out.excess(&decode(&image, level));
            if excess < best.0 {
                best = (excess, margin);
            }
            image.truncate(level);
            if excess == 0.0 {
                break;
            }
        }
        let apart = cut_out.apart(pixels, best.1);
        job.add_level(&mut image, level, Pixels::Rgba16(&apart));
    }
    image
}

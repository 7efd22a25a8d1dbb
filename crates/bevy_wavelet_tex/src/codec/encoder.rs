//! The encoder: from pixels to a [`WaveletImage`].

pub use super::check::EncodeError;
use super::{
    check::check,
    choice::{Choice, choose},
    image::{Content, WaveletImage},
    layout, plain,
    planes::LevelPlanes,
    quality,
    rate::Rate,
    settings::EncodeSettings,
    source::{LinearLevel, Pixels, Source},
};

/// Encodes an image.
///
/// Gray is the luma of YCoCg, as in the thesis; normals are X and Y of the unit vector. The result
/// does not depend on the number of threads. `progress` is called after each part with the number
/// of finished parts and their total.
///
/// # Errors
/// Returns an error when the size is out of range or does not match the number of pixels.
pub fn encode(
    source: &Source<'_>,
    settings: &EncodeSettings,
    progress: &(dyn Fn(usize, usize) + Sync),
) -> Result<WaveletImage, EncodeError> {
    check(source)?;
    let content = settings.rate.content(settings.alpha);
    let Some(wanted) = settings.min_psnr_db else {
        return Ok(encode_at(source, settings, settings.rate, progress));
    };
    let mut rates = Rate::of(content).peekable();
    while let Some(rate) = rates.next() {
        // The PSNR of the largest level decides. Mips are made only for the rate that is chosen.
        let first = Source::new(source.size, source.levels[0]);
        let trial = EncodeSettings {
            mips: false,
            ..*settings
        };
        let last = rates.peek().is_none();
        if last || quality::psnr_db(&first, &encode_at(&first, &trial, rate, &|_, _| {})) >= wanted
        {
            return Ok(encode_at(source, settings, rate, progress));
        }
    }
    unreachable!("every content has a rate")
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

fn encode_at(
    source: &Source<'_>,
    settings: &EncodeSettings,
    rate: Rate,
    progress: &(dyn Fn(usize, usize) + Sync),
) -> WaveletImage {
    let Choice { job, mut image } = choose(source, settings, rate);
    let (content, color_space) = (image.content, image.color_space);
    progress(1, image.levels as usize);
    let mut linear: Option<LinearLevel> = None;
    for level in 1..image.levels {
        let size = layout::mip_size(source.size, level);
        let given = source.levels.get(level as usize);
        if given.is_none() {
            linear = Some(match &linear {
                Some(linear) => linear.next(),
                None => LinearLevel::below(
                    &source.levels[0],
                    source.size,
                    color_space,
                    content == Content::ColorAlpha,
                ),
            });
        }
        let pixel = |i: usize| match (given, &linear) {
            (Some(pixels), _) => pixels.get(i),
            (None, Some(linear)) => linear.get(i, color_space, content == Content::ColorAlpha),
            (None, None) => unreachable!("a level that is not given is made"),
        };
        match &mut image.plain {
            Some(plain) => {
                plain::add_level(plain, level, source.size, pixel, content, settings.effort);
            }
            None => {
                let planes = LevelPlanes::new(size, content, job.axes, pixel);
                job.next_level(planes, level, &mut image.groups);
            }
        }
        progress(level as usize + 1, image.levels as usize);
    }
    image
}

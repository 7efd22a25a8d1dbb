//! The encoder: from pixels to a [`WaveletImage`], a wavelet or a plain texture by the error of its levels.

use rayon::prelude::*;
use thiserror::Error;

use super::{
    axes::{ColorAxes, detail_covariance},
    decoder::decode,
    image::{Payload, WaveletImage},
    job::Job,
    layout, plain,
    prepare::Prepared,
    quality::{self, Errors, Window},
    rate::Rate,
    settings::{Effort, EncodeSettings, Formats, Method},
    source::{LevelPlanes, Pixels, Source},
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
        let [width, height] = layout::mip_size(size, level as u32).map(u64::from);
        let expected = width * height;
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
    let Some(cut_out) = &prepared.cut_out else {
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
        let pixels = prepared.made(level);
        let pixels = pixels.expect("mips are made for what is cut out");
        let mut best = (excess[level as usize], 0.0);
        for margin in MARGINS {
            if best.0 == 0.0 {
                break;
            }
            let apart = cut_out.apart(pixels, margin);
            job.add_level(&mut image, level, Pixels::Rgba16(&apart));
            let excess = cut_out.excess(&decode(&image, level));
            if excess < best.0 {
                best = (excess, margin);
            }
            image.truncate(level);
        }
        let apart = cut_out.apart(pixels, best.1);
        job.add_level(&mut image, level, Pixels::Rgba16(&apart));
    }
    image
}

/// The least part of the squared error that chroma must have for a wavelet with more chroma to be tried.
const CHROMA_PART: f64 = 0.5;

/// The least part of the squared error that other axes of colour must save for a wavelet with them to be
/// tried.
const AXES_PART: f64 = 0.03;

/// An image as it was chosen, and the settings of its levels.
struct Choice<'a> {
    job: Job<'a>,
    image: WaveletImage,
}

/// Encodes all levels of a source in all ways that a rate and the settings allow, and keeps those with the least error
/// over all levels.
fn choose<'a>(source: &Source<'_>, settings: &'a EncodeSettings, rate: Rate) -> Choice<'a> {
    let is_thesis = settings.method == Method::Thesis;
    let formats = match is_thesis {
        true => Formats::Wavelet,
        false => settings.formats,
    };
    let bytes = rate.most_bytes(source.size, settings.alpha);
    let gray = rate.of_gray();
    let gray = gray.filter(|_| !is_thesis && !settings.alpha && is_gray(source));
    let rate = gray.unwrap_or(rate);
    let content = rate.content(settings.alpha);
    let windows = Window::of_levels(source.size, source.levels.len());
    let wavelet = (formats != Formats::Plain).then(|| {
        let is_measured = formats == Formats::Any;
        best_wavelet(source, settings, rate, &windows, is_measured)
    });
    let (wavelet, least) = wavelet.unzip();
    let plain = (formats != Formats::Wavelet)
        .then(|| plain::better(source, content, least.flatten(), &windows, settings, bytes));
    let plain = plain.flatten().map(|image| Choice {
        job: Job::new(source, settings, rate, ColorAxes::YCOCG),
        image,
    });
    plain.or(wavelet).expect("every rate has room for a block")
}

/// Returns whether no pixel has a colour.
fn is_gray(source: &Source<'_>) -> bool {
    let is_gray = |pixels: &Pixels<'_>| {
        (0..pixels.len()).into_par_iter().all(|i| {
            let [r, g, b, _] = pixels.get(i);
            r == g && g == b
        })
    };
    source.levels.iter().all(is_gray)
}

/// The wavelet with the least error over all levels, and its errors where they decided or where `is_measured` asks for
/// them.
fn best_wavelet<'a>(
    source: &Source<'_>,
    settings: &'a EncodeSettings,
    rate: Rate,
    windows: &[Vec<Window>],
    is_measured: bool,
) -> (Choice<'a>, Option<Errors>) {
    let ycocg = ColorAxes::YCOCG;
    let mut choice = Choice::wavelet(source, settings, rate.wavelet(), ycocg);
    let measured = |choice: &Choice<'_>| Errors::of(source, &choice.image, windows);
    let has_variants = choice.image.content.has_chroma()
        && settings.method != Method::Thesis
        && settings.effort != Effort::Fast;
    if !has_variants {
        let errors = is_measured.then(|| measured(&choice));
        return (choice, errors);
    }
    let mut errors = measured(&choice);
    let better = |rate, axes, than: f64| {
        let other = Choice::wavelet(source, settings, rate, axes);
        let errors = measured(&other);
        (errors.all < than).then_some((other, errors))
    };
    if let Some(rate) = rate.with_more_chroma()
        && errors.luma < (1.0 - CHROMA_PART) * errors.all
        && let Some(other) = better(rate, ycocg, errors.all)
    {
        (choice, errors) = other;
    }
    if let Some(axes) = fitted_axes(source, choice.job.rate, errors)
        && let Some(other) = better(choice.job.rate, axes, errors.all)
    {
        (choice, errors) = other;
    }
    (choice, Some(errors))
}

/// The axes of colour that fit an image, where they may have less error than YCoCg: chroma has less where less of it is
/// lost by its smaller size.
fn fitted_axes(source: &Source<'_>, rate: Rate, errors: Errors) -> Option<ColorAxes> {
    let Errors { all, luma, .. } = errors;
    let subsampling = rate.chroma_subsampling()?;
    if luma > (1.0 - AXES_PART) * all {
        return None;
    }
    // The energy that is lost is nearly all of the error of chroma.
    let lost = detail_covariance(&source.levels[0], source.size, subsampling);
    let fitted = ColorAxes::fitted(&lost)?;
    let part = fitted.chroma_energy(&lost) / ColorAxes::YCOCG.chroma_energy(&lost);
    let expected = luma + part * (all - luma);
    (expected < (1.0 - AXES_PART) * all).then_some(fitted)
}

impl<'a> Choice<'a> {
    fn wavelet(
        source: &Source<'_>,
        settings: &'a EncodeSettings,
        rate: Rate,
        axes: ColorAxes,
    ) -> Self {
        let job = Job::new(source, settings, rate, axes);
        let content = rate.content(settings.alpha);
        let image = WaveletImage {
            content,
            color_space: settings.stored_color_space(),
            size: source.size,
            levels: source.levels.len() as u32,
            payload: Payload::Wavelet(job.planes(&LevelPlanes::of(source, content, axes))),
        };
        Self { job, image }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codec::image::Content;

    const SIZE: [u32; 2] = [64, 64];

    fn picture(color: fn(u32, u32) -> [u8; 3]) -> Vec<[u8; 3]> {
        let positions = (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| (x, y)));
        positions.map(|(x, y)| color(x, y)).collect()
    }

    #[test]
    fn images_without_colour_have_the_bits_of_gray() {
        let settings = |rate| EncodeSettings {
            rate,
            mips: false,
            formats: Formats::Wavelet,
            ..EncodeSettings::default()
        };
        let encoded = |pixels: &[[u8; 3]], rate| {
            encode_rgb8(pixels, SIZE, &settings(rate)).expect("a good image")
        };
        let gray = picture(|x, y| [(x * 3 + y * y % 50 + x * y % 7) as u8; 3]);
        let mut tinted = gray.clone();
        tinted[77][0] ^= 1;
        for rate in [
            Rate::Color2_25,
            Rate::Color3,
            Rate::Color3_25,
            Rate::Color4,
            Rate::Color5,
        ] {
            let image = encoded(&gray, rate);
            match rate.of_gray() {
                Some(of_gray) => assert_eq!(image, encoded(&gray, of_gray)),
                None => assert_eq!(image.content, Content::Color),
            }
            assert!(image.bits_per_pixel() <= rate.nominal_bits_per_pixel(false));
            assert_eq!(encoded(&tinted, rate).content, Content::Color);
        }
    }
}

//! The choice between wavelets and plain textures for an image, by the error of its levels.

use rayon::prelude::*;

use super::{
    axes::{ColorAxes, detail_covariance},
    image::{Payload, WaveletImage},
    job::Job,
    plain,
    planes::LevelPlanes,
    quality::Errors,
    rate::Rate,
    settings::{Effort, EncodeSettings, Formats, Method},
    source::{Pixels, Source},
    windows::Window,
};

/// The least part of the squared error that chroma must have for a wavelet with more chroma to be tried.
const CHROMA_PART: f64 = 0.5;

/// The least part of the squared error that other axes of colour must save for a wavelet with them to be
/// tried.
const AXES_PART: f64 = 0.03;

/// An image as it was chosen, and the settings of its levels.
pub(super) struct Choice<'a> {
    pub(super) job: Job<'a>,
    pub(super) image: WaveletImage,
}

/// Encodes all levels of a source in all ways that a rate and the settings allow, and keeps those with the least error
/// over all levels.
pub(super) fn choose<'a>(
    source: &Source<'_>,
    settings: &'a EncodeSettings,
    rate: Rate,
) -> Choice<'a> {
    let formats = match settings.method {
        Method::Thesis => Formats::Wavelet,
        _ => settings.formats,
    };
    let bytes = rate.most_bytes(source.size, settings.alpha);
    let gray = match settings.method {
        Method::Thesis => None,
        _ => rate
            .of_gray()
            .filter(|_| !settings.alpha && is_gray(source)),
    };
    let rate = gray.unwrap_or(rate);
    let content = rate.content(settings.alpha);
    let windows = Window::of_levels(source.size, source.levels.len());
    let (wavelet, least) = match formats {
        Formats::Plain => (None, None),
        Formats::Any | Formats::Wavelet => {
            let is_measured = formats == Formats::Any;
            let (choice, errors) = best_wavelet(source, settings, rate, &windows, is_measured);
            (Some(choice), errors)
        }
    };
    let plain = match formats {
        Formats::Wavelet => None,
        Formats::Any | Formats::Plain => {
            plain::better(source, content, least, &windows, settings, bytes)
        }
    };
    let plain = plain.map(|image| Choice {
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
    use crate::codec::{encoder::encode_rgb8, image::Content};

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

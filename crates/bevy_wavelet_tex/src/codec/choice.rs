//! The choice between wavelets and plain textures for an image, by the error of its levels.

use super::{
    axes::{ColorAxes, detail_covariance},
    image::{Payload, WaveletImage},
    job::Job,
    plain,
    planes::LevelPlanes,
    quality::Errors,
    rate::Rate,
    settings::{Effort, EncodeSettings, Formats, Method},
    source::Source,
    windows::Window,
};

/// The least part of the squared error that chroma must have for a wavelet with more chroma to be tried.
const CHROMA_PART: f64 = 0.5;

/// The least part of the squared error that other axes of colour must save for a wavelet with them to be
/// tried.
const AXES_PART: f64 = 0.05;

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
    let bytes = rate.most_bytes(source.size, settings.alpha);
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

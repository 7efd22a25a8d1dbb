//! The choice between wavelets and plain textures for an image, by the error of its first level.

use super::{
    image::{ColorSpace, Content, WaveletImage},
    job::Job,
    layout,
    plain::{self, PlainTexture},
    plane::union,
    planes::LevelPlanes,
    quality,
    rate::Rate,
    settings::{Effort, EncodeSettings, Formats, Method},
    source::Source,
};

/// The least part of the squared error that chroma must have for a wavelet with more chroma to be tried.
const CHROMA_PART: f64 = 0.5;

/// The first level of an image as it was chosen, and the settings for its other levels.
pub(super) struct Choice<'a> {
    pub(super) job: Job<'a>,
    pub(super) image: WaveletImage,
}

/// Encodes the first level in all ways that a rate and the settings allow, and keeps the one with the
/// least error. `levels` of the image is the number of levels that it will have.
pub(super) fn choose<'a>(
    source: &Source<'_>,
    settings: &'a EncodeSettings,
    rate: Rate,
) -> Choice<'a> {
    let formats = match settings.method {
        Method::Thesis => Formats::Wavelet,
        _ => settings.formats,
    };
    let bits = rate.nominal_bits_per_pixel(settings.alpha);
    let mut choice = match formats {
        Formats::Plain => Choice::empty(source, settings, rate.wavelet()),
        Formats::Any | Formats::Wavelet => Choice::wavelet(source, settings, rate.wavelet()),
    };
    let more_chroma = rate
        .with_more_chroma()
        .filter(|_| settings.method != Method::Thesis && settings.effort != Effort::Fast);
    let mut least = f64::INFINITY;
    if formats == Formats::Any || formats == Formats::Wavelet && more_chroma.is_some() {
        least = quality::mse(source, &choice.image);
    }
    if let Some(rate) = more_chroma.filter(|_| formats != Formats::Plain)
        && quality::luma_mse(source, &choice.image) < (1.0 - CHROMA_PART) * least
    {
        let other = Choice::wavelet(source, settings, rate);
        let mse = quality::mse(source, &other.image);
        if mse < least {
            (choice, least) = (other, mse);
        }
    }
    if formats != Formats::Wavelet {
        choice.image.plain = plain::better(source, &choice.image, least, settings, bits);
    }
    match &choice.image.plain {
        Some(plain) => {
            choice.image.groups.clear();
            choice.image.levels =
                levels(source, settings, PlainTexture::max_level_count(plain.size));
        }
        // The image is smaller than a block.
        None if choice.image.groups.is_empty() => {
            choice = Choice::wavelet(source, settings, rate.wavelet());
        }
        None => {}
    }
    choice
}

impl<'a> Choice<'a> {
    fn empty(source: &Source<'_>, settings: &'a EncodeSettings, rate: Rate) -> Self {
        let content = rate.content(settings.alpha);
        Self {
            job: Job {
                settings,
                rate,
                size: source.size,
            },
            image: WaveletImage {
                content,
                color_space: match content {
                    Content::Normal => ColorSpace::Linear,
                    _ => settings.color_space,
                },
                size: source.size,
                levels: 1,
                groups: Vec::new(),
                plain: None,
            },
        }
    }

    fn wavelet(source: &Source<'_>, settings: &'a EncodeSettings, rate: Rate) -> Self {
        let mut choice = Self::empty(source, settings, rate);
        let content = choice.image.content;
        let levels = levels(source, settings, choice.job.max_level_count());
        let planes = LevelPlanes::given(&source.levels[0], source.size, content);
        let bounds = given_bounds(source, content, levels as usize);
        choice.image.groups = choice.job.first_level(planes, &bounds);
        choice.image.levels = levels;
        choice
    }
}

/// Number of levels that are encoded where there can be at most `most`.
fn levels(source: &Source<'_>, settings: &EncodeSettings, most: u32) -> u32 {
    match source.levels.len() as u32 {
        1 if settings.mips => most,
        given => given.min(most),
    }
}

/// Bounds of the luma and chroma planes over the given mips. Mips that are not filtered from the
/// first level can exceed its bounds.
fn given_bounds(source: &Source<'_>, content: Content, levels: usize) -> [Vec<[f32; 2]>; 2] {
    let mut all: [Vec<[f32; 2]>; 2] = [Vec::new(), Vec::new()];
    for (level, pixels) in source.levels.iter().enumerate().take(levels).skip(1) {
        let size = layout::mip_size(source.size, level as u32);
        let planes = LevelPlanes::given(pixels, size, content);
        for (all, planes) in all.iter_mut().zip([&planes.luma, &planes.chroma]) {
            all.resize(planes.len(), [f32::INFINITY, f32::NEG_INFINITY]);
            for (all, plane) in all.iter_mut().zip(planes) {
                *all = union(*all, plane.bounds());
            }
        }
    }
    all
}

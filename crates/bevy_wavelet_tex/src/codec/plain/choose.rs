//! The choice between a wavelet and plain textures of the same bits.

use super::{
    encode::channels,
    estimate::{Candidate, LEAST_BLOCKS},
    texture::PlainTexture,
};
use crate::codec::{
    image::{Content, WaveletImage},
    quality,
    settings::{Effort, EncodeSettings},
    source::Source,
};

/// An estimate may be wrong by this factor of the error: 0.25 dB.
const DOUBT: f64 = 1.06;

/// The first level of the plain texture that has the least error of all formats and sizes, where its mean squared error in 8-bit
/// units is less than `least`. `image` says what it is of, `bytes` are the most that it may take.
pub(in crate::codec) fn better(
    source: &Source<'_>,
    image: &WaveletImage,
    mut least: f64,
    settings: &EncodeSettings,
    bytes: usize,
) -> Option<PlainTexture> {
    let content = image.content;
    let pixels = &source.levels[0];
    let channels = channels(content, source.size, |i| pixels.get(i));
    let encoded = |candidate: Candidate| {
        let image = WaveletImage {
            levels: 1,
            groups: Vec::new(),
            plain: Some(candidate.encoded(settings.effort)),
            ..*image
        };
        (quality::mse(source, &image), image.plain)
    };
    // Errors of normals are those of X, Y and Z, of which the channels are two.
    let most = |least: f64| match content {
        Content::Normal => f64::INFINITY,
        _ => least * DOUBT / (255.0 * 255.0),
    };
    // The estimate of a small texture has all of its blocks, and measures no less.
    let full = PlainTexture::full_size(source.size);
    let is_small = full[0] / 4 * (full[1] / 4) <= LEAST_BLOCKS;
    let mut best = None;
    let mut promising: Option<(f64, Candidate)> = None;
    for &format in PlainTexture::formats(content) {
        for size in PlainTexture::sizes_within(source.size, format, bytes) {
            let candidate = Candidate::new(&channels, format, size);
            if is_small || settings.effort == Effort::Best {
                let (mse, plain) = encoded(candidate);
                if mse < least {
                    (least, best) = (mse, plain);
                }
                continue;
            }
            let most = promising.as_ref().map_or(most(least), |(error, _)| *error);
            let mut error = candidate.error_of_size();
            if error < most {
                error = candidate.estimated_error(error);
            }
            if error < most {
                promising = Some((error, candidate));
            }
        }
    }
    if let Some((_, candidate)) = promising {
        let (mse, plain) = encoded(candidate);
        if mse < least {
            best = plain;
        }
    }
    best
}

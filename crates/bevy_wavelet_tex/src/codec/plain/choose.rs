//! The choice between a wavelet and plain textures of the same bits.

use super::{
    encode::{blocks, channels, texels},
    estimate::{error_of_size, error_of_strips},
    texture::PlainTexture,
};
use crate::codec::{
    blocks::BlockFormat,
    image::{Content, WaveletImage},
    quality,
    settings::{Effort, EncodeSettings},
    source::Source,
};

/// An estimate may be wrong by this factor of the error: less than 0.2 dB.
const DOUBT: f64 = 1.04;

/// The first level of the plain texture that has the least error, where its mean squared error in 8-bit
/// units is less than `least`. `image` says what it is of, `bits` are the most bits per pixel that it may
/// take.
pub(in crate::codec) fn better(
    source: &Source<'_>,
    image: &WaveletImage,
    mut least: f64,
    settings: &EncodeSettings,
    bits: f64,
) -> Option<PlainTexture> {
    let content = image.content;
    let mut best = None;
    let pixels = &source.levels[0];
    let channels = channels(content, source.size, |i| pixels.get(i));
    for &format in PlainTexture::formats(content) {
        let Some(size) = size_within(source.size, format, bits) else {
            continue;
        };
        let texels = texels(&channels, size);
        // Errors of normals are those of X, Y and Z, of which these are two.
        let worse = |mse: f64| content != Content::Normal && mse * 255.0 * 255.0 > least * DOUBT;
        if size != source.size && worse(error_of_size(&channels, &texels)) {
            continue;
        }
        let estimate = error_of_strips(&channels, &texels, format);
        if settings.effort != Effort::Best && estimate.is_some_and(worse) {
            continue;
        }
        let candidate = WaveletImage {
            levels: 1,
            groups: Vec::new(),
            plain: Some(PlainTexture {
                format,
                size,
                blocks: blocks(format, &texels, settings.effort),
            }),
            ..*image
        };
        let mse = quality::mse(source, &candidate);
        if mse < least {
            least = mse;
            best = candidate.plain;
        }
    }
    best
}

/// The largest size of a texture of a format that takes at most `bits` per pixel of an image, or
/// `None` where not a block does.
fn size_within(image: [u32; 2], format: BlockFormat, bits: f64) -> Option<[u32; 2]> {
    let bits_per_texel = format.block_bytes() as f64 / 2.0;
    let whole_blocks = |texels: f64| texels as u32 / 4 * 4;
    let [width, height] = image.map(f64::from);
    let w = whole_blocks(width * (bits / bits_per_texel).sqrt().min(1.0));
    if w == 0 {
        return None;
    }
    let texels = width * height * bits / bits_per_texel;
    let h = whole_blocks((texels / f64::from(w)).min(height));
    PlainTexture::is_valid_size([w, h], image).then_some([w, h])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_take_the_bits_and_no_more() {
        for image in [
            [512, 512],
            [1024, 256],
            [768, 512],
            [93, 61],
            [4, 4],
            [17, 300],
        ] {
            for bits in [2.0, 2.25, 3.0, 3.25, 4.0, 5.0, 8.0] {
                for format in [BlockFormat::Bc1, BlockFormat::Bc7] {
                    let Some(size) = size_within(image, format, bits) else {
                        assert!(image.iter().any(|s| *s < 8), "{image:?}");
                        continue;
                    };
                    let pixels = f64::from(image[0] * image[1]);
                    let taken = 8.0 * format.level_bytes(size) as f64 / pixels;
                    assert!(taken <= bits, "{image:?} {bits}: {size:?}");
                    assert!(size.iter().all(|s| s % 4 == 0));
                    let whole = image.iter().all(|s| s % 4 == 0);
                    if whole && bits >= format.block_bytes() as f64 / 2.0 {
                        assert_eq!(size, image);
                    }
                }
            }
        }
        assert_eq!(
            size_within([512, 512], BlockFormat::Bc1, 2.25),
            Some([384, 384])
        );
        assert_eq!(size_within([3, 9], BlockFormat::Bc1, 4.0), None);
    }
}

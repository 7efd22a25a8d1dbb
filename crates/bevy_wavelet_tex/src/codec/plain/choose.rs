//! The choice between a wavelet and plain textures of the same bits.

use super::{
    encode::{Channels, add_level},
    estimate::{LEAST_BLOCKS, LevelTexels},
    texture::PlainTexture,
};
use crate::codec::{
    axes::ColorAxes,
    blocks::BlockFormat,
    image::{Content, WaveletImage},
    layout,
    quality::{chain_mse, level_weight},
    settings::{Effort, EncodeSettings},
    source::Source,
};

/// An estimate may be wrong by this factor of the error: 0.25 dB.
const DOUBT: f64 = 1.06;

/// The format and the size of the largest level of a plain texture.
#[derive(Clone, Copy)]
struct Candidate {
    format: BlockFormat,
    size: [u32; 2],
}

/// The plain texture that has the least error over all levels, of all formats and sizes, where its mean squared error in
/// 8-bit units is less than `least`. `image` says what it is of, `bytes` are the most that its first level may take.
pub(in crate::codec) fn better(
    source: &Source<'_>,
    image: &WaveletImage,
    mut least: f64,
    settings: &EncodeSettings,
    bytes: usize,
) -> Option<WaveletImage> {
    let content = image.content;
    let levels: Vec<Channels<'_>> = source
        .levels
        .iter()
        .enumerate()
        .map(|(level, pixels)| {
            Channels::new(
                *pixels,
                layout::mip_size(source.size, level as u32),
                content,
            )
        })
        .collect();
    let encoded = |candidate: Candidate| {
        let mut plain = candidate.empty();
        let count = candidate.levels(source);
        for (level, channels) in levels.iter().enumerate().take(count) {
            add_level(
                &mut plain,
                level as u32,
                source.size,
                channels,
                settings.effort,
            );
        }
        let image = WaveletImage {
            levels: count as u32,
            groups: Vec::new(),
            axes: ColorAxes::YCOCG,
            plain: Some(plain),
            ..*image
        };
        (chain_mse(source, &image), image)
    };
    // Errors of normals are those of X, Y and Z, of which the channels are two.
    let mut most = match content {
        Content::Normal => f64::INFINITY,
        _ => least * DOUBT / (255.0 * 255.0),
    };
    // The estimate of a small texture has all of its blocks, and measures no less.
    let full = PlainTexture::full_size(source.size);
    let is_small = full[0] / 4 * (full[1] / 4) <= LEAST_BLOCKS;
    let mut best = None;
    let mut promising = None;
    for &format in PlainTexture::formats(content) {
        for size in PlainTexture::sizes_within(source.size, format, bytes) {
            let candidate = Candidate { format, size };
            if is_small || settings.effort == Effort::Best {
                let (mse, image) = encoded(candidate);
                if mse < least {
                    (least, best) = (mse, Some(image));
                }
            } else if let Some(error) = candidate.estimated_error(source, &levels, most) {
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

    /// An estimate of the mean squared error of all levels, by how much they are used, where it is less than `most`.
    fn estimated_error(
        self,
        source: &Source<'_>,
        levels: &[Channels<'_>],
        most: f64,
    ) -> Option<f64> {
        let levels = &levels[..self.levels(source)];
        let is_scaled = self.empty().is_scaled(source.size);
        let total: f64 = (0..levels.len()).map(level_weight).sum();
        let mut sum = 0.0;
        for (level, channels) in levels.iter().enumerate() {
            let part = level_weight(level) / total;
            let size = layout::mip_size(self.size, level as u32);
            let texels = LevelTexels::new(channels, self.format, size, is_scaled);
            let error = texels.error_of_size();
            if sum + part * error >= most {
                return None;
            }
            sum += part * texels.estimated_error(error);
            if sum >= most {
                return None;
            }
        }
        Some(sum)
    }
}

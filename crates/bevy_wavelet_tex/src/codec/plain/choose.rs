//! The choice between a wavelet and plain textures of the same bits.

use super::{
    encode::{Channels, add_level},
    estimate::LevelEstimate,
    texture::PlainTexture,
};
use crate::codec::{
    blocks::BlockFormat,
    image::{Content, Payload, WaveletImage},
    layout,
    quality::{Errors, level_weight},
    settings::{Effort, EncodeSettings},
    source::Source,
    windows::Window,
};

/// A texture is encoded where its error in the windows, before it is refined by pixels, is at most this factor of that
/// of the wavelet.
const DOUBT: f64 = 1.08;

/// Textures of no more blocks are encoded without an estimate: those of 192 x 192 texels.
const LEAST_BLOCKS: u32 = 2304;

/// Textures of no more blocks, those of sprites, are worth the best effort.
const FEW_BLOCKS: u32 = 256;

/// The format and the size of the largest level of a plain texture.
#[derive(Clone, Copy)]
struct Candidate {
    format: BlockFormat,
    size: [u32; 2],
}

/// The plain texture that has the least error over all levels, of all formats and sizes, where its mean squared error in
/// 8-bit units is less than that of the errors `least`, if there are any. `windows` are those of each level, and `bytes`
/// are the most that its first level may take.
pub(in crate::codec) fn better(
    source: &Source<'_>,
    content: Content,
    least: Option<Errors>,
    windows: &[Vec<Window>],
    settings: &EncodeSettings,
    bytes: usize,
) -> Option<WaveletImage> {
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
    let full = PlainTexture::full_size(source.size);
    let blocks = full[0] / 4 * (full[1] / 4);
    let effort = match settings.effort {
        Effort::Default if blocks <= FEW_BLOCKS => Effort::Best,
        effort => effort,
    };
    let encoded = |candidate: Candidate| {
        let mut plain = candidate.empty();
        let count = candidate.levels(source);
        for (level, channels) in levels.iter().enumerate().take(count) {
            add_level(&mut plain, level as u32, source.size, channels, effort);
        }
        let image = WaveletImage {
            content,
            color_space: settings.stored_color_space(),
            size: source.size,
            levels: count as u32,
            payload: Payload::Plain(plain),
        };
        (Errors::of(source, &image, windows).all, image)
    };
    let mut most = least.map_or(f64::INFINITY, |errors| DOUBT * errors.in_windows);
    let mut least = least.map_or(f64::INFINITY, |errors| errors.all);
    let mut best = None;
    let mut promising = None;
    for &format in PlainTexture::formats(content) {
        for size in PlainTexture::sizes_within(source.size, format, bytes) {
            let candidate = Candidate { format, size };
            if blocks <= LEAST_BLOCKS || settings.effort == Effort::Best {
                let (mse, image) = encoded(candidate);
                if mse < least {
                    (least, best) = (mse, Some(image));
                }
            } else if let Some(error) =
                candidate.estimated_error(source, &levels, windows, most, settings.effort)
            {
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

    /// The mean squared error of the windows of all levels, by how much these are used, where it is less than `most`.
    fn estimated_error(
        self,
        source: &Source<'_>,
        levels: &[Channels<'_>],
        windows: &[Vec<Window>],
        most: f64,
        effort: Effort,
    ) -> Option<f64> {
        let count = self.levels(source);
        let is_scaled = self.empty().is_scaled(source.size);
        let total: f64 = (0..count).map(level_weight).sum();
        let mut sum = 0.0;
        let levels = levels.iter().zip(windows).take(count);
        for (level, (channels, windows)) in levels.enumerate() {
            let part = level_weight(level) / total;
            let size = layout::mip_size(self.size, level as u32);
            let estimate = LevelEstimate::new(channels, self.format, size, is_scaled, windows);
            if is_scaled && sum + part * estimate.error_of_size() >= most {
                return None;
            }
            sum += part * estimate.error(effort);
            if sum >= most {
                return None;
            }
        }
        Some(sum)
    }
}

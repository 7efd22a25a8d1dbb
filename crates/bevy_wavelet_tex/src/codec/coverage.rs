//! Mips of what is cut out by its alpha: they cover as much of the image as its largest level does.
//!
//! Filtered alpha does not: where a part is thinner than a pixel of a mip, no pixel of it reaches the cutoff.
//! So the alpha of each mip is multiplied by a factor (Castaño 2010, "Computing Alpha Mipmaps").

use rayon::prelude::*;

use super::{
    decoder::DecodedImage,
    image::{ColorSpace, Content},
    settings::EncodeSettings,
    source::Source,
};

/// What is cut out of an image.
#[derive(Clone, Copy)]
pub(super) struct CutOut {
    content: Content,
    /// The value from which on a pixel is there.
    cutoff: f32,
    /// The part of the pixels that are there.
    coverage: f64,
}

impl CutOut {
    pub(super) fn of(
        source: &Source<'_>,
        settings: &EncodeSettings,
        content: Content,
    ) -> Option<Self> {
        let cutoff = settings.alpha_cutoff?;
        let channel = match content {
            Content::ColorAlpha => 3,
            Content::Gray if settings.color_space == ColorSpace::Linear => 0,
            _ => return None,
        };
        let first = &source.levels[0];
        let there = (0..first.len()).filter(|i| first.get(*i)[channel] >= cutoff);
        let coverage = there.count() as f64 / first.len() as f64;
        Some(Self {
            content,
            cutoff,
            coverage,
        })
    }

    /// Multiplies what is cut in the pixels of a mip so that as much is there as is wanted.
    pub(super) fn scale(&self, pixels: &mut [[u16; 4]]) {
        let values: Vec<f32> = pixels.iter().map(|p| self.value(p)).collect();
        let factor = coverage_scale(&values, self.coverage, self.cutoff);
        for (pixel, value) in pixels.iter_mut().zip(values) {
            self.set(pixel, value * factor);
        }
    }

    /// The pixels of a mip with all values at least this far from the cutoff, on the same side of it.
    pub(super) fn apart(&self, pixels: &[[u16; 4]], distance: f32) -> Vec<[u16; 4]> {
        let apart = |pixel: &[u16; 4]| {
            let (mut pixel, value) = (*pixel, self.value(pixel));
            let moved = if value >= self.cutoff {
                value.max(self.cutoff + distance)
            } else {
                value.min(self.cutoff - distance)
            };
            self.set(&mut pixel, moved);
            pixel
        };
        pixels.iter().map(apart).collect()
    }

    fn value(&self, pixel: &[u16; 4]) -> f32 {
        let channel = if self.content == Content::ColorAlpha {
            3
        } else {
            0
        };
        f32::from(pixel[channel]) / 65535.0
    }

    fn set(&self, pixel: &mut [u16; 4], value: f32) {
        let word = (value.clamp(0.0, 1.0) * 65535.0).round() as u16;
        match self.content {
            Content::ColorAlpha => pixel[3] = word,
            _ => pixel[..3].fill(word),
        }
    }

    /// How much more or less of a decoded level is there than wanted; 0 where that is less than one in a hundred
    /// pixels, or half a pixel.
    pub(super) fn excess(&self, decoded: &DecodedImage) -> f64 {
        // A GPU compares with what 8 bits have.
        let is_there = |v: f32| (v * 255.0).round() / 255.0 >= self.cutoff;
        let there = match &decoded.alpha {
            Some(alpha) => alpha.iter().filter(|a| is_there(**a)).count(),
            None => decoded.pixels.iter().filter(|p| is_there(p[0])).count(),
        };
        let pixels = decoded.pixels.len() as f64;
        let excess = (there as f64 / pixels - self.coverage).abs();
        if excess <= (0.5 / pixels).max(0.01) {
            0.0
        } else {
            excess
        }
    }
}

/// The factor by which alpha is multiplied so that `wanted` of all pixels are at least at the cutoff, as nearly
/// as the pixels allow.
fn coverage_scale(alpha: &[f32], coverage: f64, cutoff: f32) -> f32 {
    let mut sorted = alpha.to_vec();
    sorted.par_sort_unstable_by(|a, b| b.total_cmp(a));
    let count = coverage * sorted.len() as f64;
    // Pixels of the same alpha are covered together or not at all: the boundary is before or after them.
    let at = (count.round() as usize).min(sorted.len());
    let is_boundary = |i: &usize| *i == 0 || *i == sorted.len() || sorted[i - 1] > sorted[*i];
    let before = (0..=at).rev().find(is_boundary).unwrap_or(0);
    let after = (at..=sorted.len())
        .find(is_boundary)
        .unwrap_or(sorted.len());
    let boundary = if count - before as f64 <= after as f64 - count {
        before
    } else {
        after
    };
    let threshold = match boundary {
        0 => sorted[0] + 1.0 / 255.0,
        all if all == sorted.len() => 0.5 * sorted.iter().rev().find(|v| **v > 0.0).unwrap_or(&0.0),
        i => 0.5 * (sorted[i - 1] + sorted[i]),
    };
    if threshold > 0.0 {
        cutoff / threshold
    } else {
        1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scaled_alpha_covers_what_is_wanted() {
        let alpha: Vec<f32> = (0..1000)
            .map(|i| (i * 7919 % 1000) as f32 / 2000.0)
            .collect();
        for coverage in [0.0, 0.01, 0.19, 0.5, 0.93, 1.0] {
            let scale = coverage_scale(&alpha, coverage, 0.5);
            let there = alpha.iter().filter(|a| **a * scale >= 0.5).count();
            let found = there as f64 / alpha.len() as f64;
            assert!((found - coverage).abs() < 0.0011, "{coverage}: {found}");
        }
        // Of equal values all are covered, or none.
        assert!(coverage_scale(&[0.3; 8], 0.7, 0.5) * 0.3 >= 0.5);
        assert!(coverage_scale(&[0.3; 8], 0.2, 0.5) * 0.3 < 0.5);
    }
}

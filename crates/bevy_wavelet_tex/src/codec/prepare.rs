//! What is done to pixels before anything is encoded: one channel of them becomes gray, pixels that nobody sees get a
//! colour that costs next to nothing, and mips are made where none are given.
//!
//! Mips of what is cut out by its alpha cover as much of the image as its largest level does. Filtered alpha does not:
//! where a part is thinner than a pixel of a mip, no pixel of it reaches the cutoff. So the alpha of each mip is
//! multiplied by a factor (Castaño 2010, "Computing Alpha Mipmaps").

use rayon::prelude::*;

use super::{
    decoder::DecodedImage,
    image::{ColorSpace, Content},
    layout::{level_count, mip_size},
    plane::next_mip_of,
    settings::{EncodeSettings, GrayChannel},
    source::{LinearLevel, OwnedPixels, Pixels, Source},
};

/// A source with all levels that are encoded, some of which may replace those that were given.
pub(super) struct Prepared<'a> {
    source: &'a Source<'a>,
    /// The levels that are not those that were given. Those beyond the source are mips that were made.
    own: Vec<Option<OwnedPixels>>,
    /// What is cut out of the image, where its mips were made so that they cover as much.
    pub(super) cut_out: Option<CutOut>,
}

impl<'a> Prepared<'a> {
    pub(super) fn new(source: &'a Source<'a>, settings: &EncodeSettings) -> Self {
        let content = settings.rate.content(settings.alpha);
        let level = |(level, pixels): (usize, &Pixels<'_>)| match (content, settings.gray) {
            (Content::Gray, GrayChannel::Red) => one_channel(pixels, 0),
            (Content::Gray, GrayChannel::Alpha) => one_channel(pixels, 3),
            (Content::ColorAlpha, _) => filled(pixels, mip_size(source.size, level as u32)),
            _ => None,
        };
        let own = source.levels.iter().enumerate().map(level).collect();
        let mut prepared = Self {
            source,
            own,
            cut_out: None,
        };
        if settings.mips && source.levels.len() == 1 {
            prepared.make_mips(settings, content);
        }
        prepared
    }

    fn make_mips(&mut self, settings: &EncodeSettings, content: Content) {
        let first = self.source();
        let space = settings.stored_color_space();
        let has_alpha = content == Content::ColorAlpha;
        let cut_out = CutOut::of(&first, settings, content);
        let mut mips = Vec::new();
        let mut size = first.size;
        let mut linear: Option<LinearLevel> = None;
        while size != [1, 1] {
            let level = match &linear {
                Some(level) => level.next(),
                None => LinearLevel::below(&first.levels[0], size, space, has_alpha),
            };
            let mut pixels = level.encoded(space, has_alpha);
            if let Some(cut_out) = &cut_out {
                cut_out.scale(&mut pixels);
            }
            mips.push(Some(OwnedPixels::Rgba16(pixels)));
            size = level.size;
            linear = Some(level);
        }
        self.own.extend(mips);
        self.cut_out = cut_out;
    }

    /// All levels.
    pub(super) fn source(&self) -> Source<'_> {
        let most = level_count(self.source.size) as usize;
        let levels = self.own.iter().take(most).enumerate();
        let levels = levels.map(|(i, own)| match own {
            Some(own) => own.pixels(),
            None => self.source.levels[i],
        });
        Source {
            size: self.source.size,
            levels: levels.collect(),
        }
    }

    /// The pixels of a mip that was made.
    pub(super) fn made(&self, level: u32) -> Option<&[[u16; 4]]> {
        match self.own.get(level as usize) {
            Some(Some(OwnedPixels::Rgba16(pixels)))
                if level as usize >= self.source.levels.len() =>
            {
                Some(pixels)
            }
            _ => None,
        }
    }
}

fn one_channel(pixels: &Pixels<'_>, channel: usize) -> Option<OwnedPixels> {
    Some(match pixels {
        Pixels::Gray8(_) | Pixels::Gray16(_) if channel == 0 => return None,
        Pixels::Gray8(_) | Pixels::Gray16(_) => OwnedPixels::Gray8(vec![255; pixels.len()]),
        Pixels::Rgb8(rgb) => {
            let values = rgb.iter().map(|p| *p.get(channel).unwrap_or(&255));
            OwnedPixels::Gray8(values.collect())
        }
        Pixels::Rgba8(rgba) => OwnedPixels::Gray8(rgba.iter().map(|p| p[channel]).collect()),
        Pixels::Rgba16(rgba) => OwnedPixels::Gray16(rgba.iter().map(|p| p[channel]).collect()),
    })
}

/// The pixels with a colour in place of that of wholly transparent ones, where there are any.
fn filled(pixels: &Pixels<'_>, size: [u32; 2]) -> Option<OwnedPixels> {
    fn with<T: Copy + Default + PartialEq + Send + Sync>(
        rgba: &[[T; 4]],
        colors: impl Fn() -> Colors,
        stored: impl Fn(f32) -> T + Sync,
    ) -> Option<Vec<[T; 4]>> {
        let is_clear = |p: &[T; 4]| p[3] == T::default();
        rgba.iter().any(is_clear).then(|| {
            let colors = colors();
            let fill = |(i, p): (usize, &[T; 4])| match is_clear(p) {
                true => colors.of_pixel(i).map(&stored),
                false => *p,
            };
            rgba.par_iter().enumerate().map(fill).collect()
        })
    }
    let colors = || Colors::around(pixels, size);
    match pixels {
        Pixels::Rgba8(rgba) => {
            with(rgba, colors, |v| (v * 255.0).round() as u8).map(OwnedPixels::Rgba8)
        }
        Pixels::Rgba16(rgba) => {
            with(rgba, colors, |v| (v * 65535.0).round() as u16).map(OwnedPixels::Rgba16)
        }
        _ => None,
    }
}

/// The colours around visible pixels: means over squares that grow until they have a visible pixel in them,
/// interpolated between the squares ("pull-push", Gortler et al. 1996, The Lumigraph, section 3.4).
struct Colors {
    /// Width and height of the image.
    size: [u32; 2],
    /// Those of 2 x 2 pixels.
    squares: Squares,
}

/// RGB of the squares of an image, and their alpha.
struct Squares {
    size: [u32; 2],
    colors: Vec<[f32; 4]>,
}

impl Colors {
    fn around(pixels: &Pixels<'_>, size: [u32; 2]) -> Self {
        // Colours are weighted by alpha.
        let weighted = |i: usize| {
            let [r, g, b, alpha] = pixels.get(i);
            [r * alpha, g * alpha, b * alpha, alpha]
        };
        let mut levels = vec![next_mip_of(size, weighted)];
        while let Some((size, colors)) = levels.last()
            && *size != [1, 1]
        {
            let next = next_mip_of(*size, |i| colors[i]);
            levels.push(next);
        }
        let mut coarser: Option<Squares> = None;
        for (size, mut colors) in levels.into_iter().rev() {
            let rows = colors.par_chunks_mut(size[0] as usize).enumerate();
            rows.for_each(|(y, row)| {
                for (x, color) in row.iter_mut().enumerate() {
                    let [r, g, b, alpha] = *color;
                    let [r, g, b] = match &coarser {
                        _ if alpha > 0.0 => [r, g, b].map(|v| v / alpha),
                        Some(coarser) => coarser.at([x as u32, y as u32], size),
                        None => [0.0; 3],
                    };
                    *color = [r, g, b, alpha];
                }
            });
            coarser = Some(Squares { size, colors });
        }
        Self {
            size,
            squares: coarser.expect("there is a level"),
        }
    }

    /// RGB at a pixel, and an alpha of 0.
    fn of_pixel(&self, i: usize) -> [f32; 4] {
        let at = [i as u32 % self.size[0], i as u32 / self.size[0]];
        let [r, g, b] = self.squares.at(at, self.size);
        [r, g, b, 0.0].map(|v| v.clamp(0.0, 1.0))
    }
}

impl Squares {
    /// RGB at the centre of a pixel of an image of `size` that the squares cover.
    fn at(&self, at: [u32; 2], size: [u32; 2]) -> [f32; 3] {
        let [x, y] = [0, 1].map(|axis: usize| {
            let scale = self.size[axis] as f32 / size[axis] as f32;
            ((at[axis] as f32 + 0.5) * scale - 0.5).max(0.0)
        });
        let [across, down] = [x, y].map(|position| {
            let first = position as u32;
            [first, first + 1]
        });
        let corners = down.map(|y| {
            across.map(|x| {
                let [x, y] = [x.min(self.size[0] - 1), y.min(self.size[1] - 1)];
                self.colors[y as usize * self.size[0] as usize + x as usize]
            })
        });
        let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
        std::array::from_fn(|c| {
            let [above, below] = corners.map(|[a, b]| mix(a[c], b[c], x.fract()));
            mix(above, below, y.fract())
        })
    }
}

/// The rule by which alpha cuts parts out of an image.
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
    fn clear_pixels_take_the_colour_of_their_neighbours() {
        let size = [37, 22];
        let pixels: Vec<[u8; 4]> = (0..37 * 22)
            .map(|i| match (i % 37, i / 37) {
                (x, y) if x < 6 && y < 9 => [200, 40, 20, 255],
                (x, _) if x > 30 => [20, 40, 200, 128],
                _ => [255, 0, 255, 0],
            })
            .collect();
        let Some(OwnedPixels::Rgba8(filled)) = filled(&Pixels::Rgba8(&pixels), size) else {
            panic!("nothing is filled");
        };
        for (i, (before, after)) in pixels.iter().zip(&filled).enumerate() {
            if before[3] > 0 {
                assert_eq!(before, after);
            } else {
                assert_eq!(after[3], 0);
                assert!(
                    after[1] == 40 && after[0] <= 200 && after[2] <= 200,
                    "{i}: {after:?}"
                );
            }
        }
        assert!(filled[37 * 3 + 7][0] > 150, "{:?}", filled[37 * 3 + 7]);
        assert!(filled[37 * 3 + 29][2] > 150, "{:?}", filled[37 * 3 + 29]);
    }

    #[test]
    fn nothing_visible_is_black_and_nothing_clear_is_kept() {
        let clear = [[9, 9, 9, 0]; 12];
        let Some(OwnedPixels::Rgba8(found)) = filled(&Pixels::Rgba8(&clear), [4, 3]) else {
            panic!("nothing is filled");
        };
        assert_eq!(found, [[0; 4]; 12]);
        let opaque = [[9, 9, 9, 255]; 12];
        assert!(filled(&Pixels::Rgba8(&opaque), [4, 3]).is_none());
    }

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

//! What is done to pixels before anything is encoded: one channel of them becomes gray, pixels that nobody sees get a
//! colour that costs next to nothing, and mips are made where none are given.

use rayon::prelude::*;

use super::{
    coverage::CutOut,
    image::Content,
    layout::{level_count, mip_size},
    plane::Plane,
    settings::{EncodeSettings, GrayChannel},
    source::{LinearLevel, Pixels, Source},
};

/// The pixels of one level that are not those that were given.
enum Own {
    Given,
    Gray8(Vec<u8>),
    Gray16(Vec<u16>),
    Rgba8(Vec<[u8; 4]>),
    Rgba16(Vec<[u16; 4]>),
}

/// A source with all levels that are encoded, some of which may replace those that were given.
pub(super) struct Prepared<'a> {
    source: &'a Source<'a>,
    /// Levels beyond those of the source are mips that were made.
    own: Vec<Own>,
    cut_out: Option<CutOut>,
}

impl<'a> Prepared<'a> {
    pub(super) fn new(source: &'a Source<'a>, settings: &EncodeSettings) -> Self {
        let content = settings.rate.content(settings.alpha);
        let level = |(level, pixels): (usize, &Pixels<'_>)| match (content, settings.gray) {
            (Content::Gray, GrayChannel::Red) => one_channel(pixels, 0),
            (Content::Gray, GrayChannel::Alpha) => one_channel(pixels, 3),
            (Content::ColorAlpha, _) => filled(pixels, mip_size(source.size, level as u32)),
            _ => Own::Given,
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
        let (space, has_alpha) = (
            settings.stored_color_space(),
            content == Content::ColorAlpha,
        );
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
            mips.push(Own::Rgba16(pixels));
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
        Source {
            size: self.source.size,
            levels: levels.map(|(i, own)| self.level(i, own)).collect(),
        }
    }

    fn level<'b>(&'b self, i: usize, own: &'b Own) -> Pixels<'b> {
        match own {
            Own::Given => self.source.levels[i],
            Own::Gray8(pixels) => Pixels::Gray8(pixels),
            Own::Gray16(pixels) => Pixels::Gray16(pixels),
            Own::Rgba8(pixels) => Pixels::Rgba8(pixels),
            Own::Rgba16(pixels) => Pixels::Rgba16(pixels),
        }
    }

    /// What is cut out of the image, where its mips were made so that they cover as much.
    pub(super) fn cut_out(&self) -> Option<&CutOut> {
        self.cut_out.as_ref()
    }

    /// The pixels of a mip that was made.
    pub(super) fn made(&self, level: u32) -> Option<&[[u16; 4]]> {
        match self.own.get(level as usize) {
            Some(Own::Rgba16(pixels)) if level as usize >= self.source.levels.len() => Some(pixels),
            _ => None,
        }
    }
}

fn one_channel(pixels: &Pixels<'_>, channel: usize) -> Own {
    match pixels {
        Pixels::Gray8(_) | Pixels::Gray16(_) if channel == 0 => Own::Given,
        Pixels::Gray8(_) | Pixels::Gray16(_) => Own::Gray8(vec![255; pixels.len()]),
        Pixels::Rgb8(rgb) => Own::Gray8(
            rgb.iter()
                .map(|p| *p.get(channel).unwrap_or(&255))
                .collect(),
        ),
        Pixels::Rgba8(rgba) => Own::Gray8(rgba.iter().map(|p| p[channel]).collect()),
        Pixels::Rgba16(rgba) => Own::Gray16(rgba.iter().map(|p| p[channel]).collect()),
    }
}

/// The pixels with a colour in place of that of wholly transparent ones.
fn filled(pixels: &Pixels<'_>, size: [u32; 2]) -> Own {
    match pixels {
        Pixels::Rgba8(rgba) if rgba.iter().any(|p| p[3] == 0) => {
            let colors = Colors::around(pixels, size);
            let fill = |(i, p): (usize, &[u8; 4])| match p[3] {
                0 => [0, 1, 2, 3].map(|c| (colors.at(i)[c] * 255.0).round() as u8),
                _ => *p,
            };
            Own::Rgba8(rgba.par_iter().enumerate().map(fill).collect())
        }
        Pixels::Rgba16(rgba) if rgba.iter().any(|p| p[3] == 0) => {
            let colors = Colors::around(pixels, size);
            let fill = |(i, p): (usize, &[u16; 4])| match p[3] {
                0 => [0, 1, 2, 3].map(|c| (colors.at(i)[c] * 65535.0).round() as u16),
                _ => *p,
            };
            Own::Rgba16(rgba.par_iter().enumerate().map(fill).collect())
        }
        _ => Own::Given,
    }
}

/// The colours around visible pixels: means over squares that grow until they have a visible pixel in them,
/// interpolated between the squares ("pull-push", Gortler et al. 1996, The Lumigraph, section 3.4).
struct Colors {
    /// Width and height of the image.
    size: [u32; 2],
    /// RGB of squares of 2 x 2 pixels.
    squares: [Plane; 3],
}

impl Colors {
    fn around(pixels: &Pixels<'_>, size: [u32; 2]) -> Self {
        // Colours are weighted by alpha, which is the last of four.
        let channel = |c: usize| {
            Plane::next_mip_of(size, |i| {
                let pixel = pixels.get(i);
                pixel[c] * if c == 3 { 1.0 } else { pixel[3] }
            })
        };
        let mut levels = vec![[0, 1, 2, 3].map(channel)];
        while levels[levels.len() - 1][3].size != [1, 1] {
            levels.push(levels[levels.len() - 1].each_ref().map(Plane::next_mip));
        }
        let mut coarser: Option<[Plane; 3]> = None;
        for level in levels.into_iter().rev() {
            let [r, g, b, alpha] = level;
            let fill = |mut color: Plane, c: usize| {
                let [width, height] = color.size;
                let below = coarser.as_ref().map(|planes| &planes[c]);
                let rows = color.values.par_chunks_mut(width as usize).enumerate();
                rows.for_each(|(y, row)| {
                    for (x, value) in row.iter_mut().enumerate() {
                        let weight = alpha.values[y * width as usize + x];
                        *value = match below {
                            _ if weight > 0.0 => *value / weight,
                            Some(below) => {
                                interpolated(below, [x as u32, y as u32], [width, height])
                            }
                            None => 0.0,
                        };
                    }
                });
                color
            };
            coarser = Some([fill(r, 0), fill(g, 1), fill(b, 2)]);
        }
        Self {
            size,
            squares: coarser.expect("there is a level"),
        }
    }

    /// RGB at a pixel, and an alpha of 0.
    fn at(&self, i: usize) -> [f32; 4] {
        let at = [i as u32 % self.size[0], i as u32 / self.size[0]];
        let [r, g, b] = [0, 1, 2].map(|c: usize| interpolated(&self.squares[c], at, self.size));
        [r, g, b, 0.0].map(|v| v.clamp(0.0, 1.0))
    }
}

/// The value at the centre of a pixel of an image of `size` that a smaller plane covers.
fn interpolated(plane: &Plane, at: [u32; 2], size: [u32; 2]) -> f32 {
    let [x, y] = [0, 1].map(|axis: usize| {
        let scale = plane.size[axis] as f32 / size[axis] as f32;
        ((at[axis] as f32 + 0.5) * scale - 0.5).max(0.0)
    });
    let (left, top) = (x as u32, y as u32);
    let row = |y: u32| {
        let [a, b] = [left, left + 1].map(|x| plane.clamped(x, y));
        a + (b - a) * x.fract()
    };
    let [a, b] = [row(top), row(top + 1)];
    a + (b - a) * y.fract()
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
        let Own::Rgba8(filled) = filled(&Pixels::Rgba8(&pixels), size) else {
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
        let Own::Rgba8(found) = filled(&Pixels::Rgba8(&clear), [4, 3]) else {
            panic!("nothing is filled");
        };
        assert_eq!(found, [[0; 4]; 12]);
        let opaque = [[9, 9, 9, 255]; 12];
        assert!(matches!(
            filled(&Pixels::Rgba8(&opaque), [4, 3]),
            Own::Given
        ));
    }
}

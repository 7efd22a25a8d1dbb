//! Rates: the content of an image and its bits per pixel (thesis Table 3.2, and more).

use serde::{Deserialize, Serialize};

use super::{image::Content, layout, packing::Packing};

/// The content of an image and its bits per pixel. The numbers are those of the largest level.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Rate {
    /// Gray at 2 bpp: one wavelet plane in BC3 or BC7.
    Gray2,
    /// Gray at 3 bpp: the low band in BC4, the detail bands in BC7.
    Gray3,
    /// Gray at 4 bpp: a plain BC4 texture, or [`Self::Gray3`].
    Gray4,
    /// Colour at 2.25 bpp: luma as in [`Self::Gray2`], chroma at a quarter of the width and height.
    Color2_25,
    /// Colour at 3 bpp: luma as in [`Self::Gray2`], chroma at half the width and height.
    Color3,
    /// Colour at 3.25 bpp: luma as in [`Self::Gray3`], chroma at a quarter of the width and height.
    Color3_25,
    /// Colour at 4 bpp: luma as in [`Self::Gray3`], chroma at half the width and height.
    Color4,
    /// Colour at 5 bpp: luma in BC4 at full size, chroma at half the width and height.
    Color5,
    /// Colour at 8 bpp: a plain BC7 texture, or [`Self::Color5`].
    Color8,
    /// X and Y of normals at 4 bpp: two planes as in [`Self::Gray2`].
    Normal4,
    /// X and Y of normals at 8 bpp: a plain BC5 texture, or [`Self::Normal4`].
    Normal8,
}

/// The packings of luma in 2 bits per pixel.
const TWO_BITS: &[Packing] = &[Packing::Bc3, Packing::Bc7];

/// Of each rate, in the order of [`Rate::ALL`], its name, the content without alpha, the packings of luma, and how often
/// the size of chroma is halved.
const ROWS: [(&str, Content, &[Packing], Option<u32>); 11] = [
    ("gray2", Content::Gray, TWO_BITS, None),
    ("gray3", Content::Gray, &[Packing::Split], None),
    ("gray4", Content::Gray, &[Packing::Split], None),
    ("color2.25", Content::Color, TWO_BITS, Some(2)),
    ("color3", Content::Color, TWO_BITS, Some(1)),
    ("color3.25", Content::Color, &[Packing::Split], Some(2)),
    ("color4", Content::Color, &[Packing::Split], Some(1)),
    ("color5", Content::Color, &[Packing::Bc4], Some(1)),
    ("color8", Content::Color, &[Packing::Bc4], Some(1)),
    ("normal4", Content::Normal, TWO_BITS, None),
    ("normal8", Content::Normal, TWO_BITS, None),
];

impl Rate {
    /// All rates; those of one content are in ascending order of size.
    pub const ALL: [Self; 11] = [
        Self::Gray2,
        Self::Gray3,
        Self::Gray4,
        Self::Color2_25,
        Self::Color3,
        Self::Color3_25,
        Self::Color4,
        Self::Color5,
        Self::Color8,
        Self::Normal4,
        Self::Normal8,
    ];

    fn row(self) -> (&'static str, Content, &'static [Packing], Option<u32>) {
        ROWS[self as usize]
    }

    /// Name of the rate in the tool, such as `gray2` or `color2.25`.
    pub fn name(self) -> &'static str {
        self.row().0
    }

    /// The rate with the given name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|rate| rate.name() == name)
    }

    /// The content of the rate, with or without an alpha channel. Only colour can have one.
    pub fn content(self, alpha: bool) -> Content {
        match self.row().1 {
            Content::Color if alpha => Content::ColorAlpha,
            content => content,
        }
    }

    /// The default rate of a content: 2 bpp for gray, 3 for colour, 4 for normals.
    pub fn usual(content: Content) -> Self {
        match content {
            Content::Gray => Self::Gray2,
            Content::Color | Content::ColorAlpha => Self::Color3,
            Content::Normal => Self::Normal4,
        }
    }

    /// The rates of a content in ascending order of size.
    pub fn of(content: Content) -> impl Iterator<Item = Self> {
        let alpha = content == Content::ColorAlpha;
        let mut rates = Self::ALL.map(|rate| (rate.nominal_bits_per_pixel(alpha), rate));
        rates.sort_by(|a, b| a.0.total_cmp(&b.0));
        rates
            .into_iter()
            .map(|(_, rate)| rate)
            .filter(move |rate| rate.content(alpha) == content)
    }

    /// The rate of the wavelet that the encoder considers first: the rate itself, or the next smaller
    /// one where all of its bits are for a plain texture.
    pub fn wavelet(self) -> Self {
        match self {
            Self::Gray4 => Self::Gray3,
            Self::Color8 => Self::Color5,
            Self::Normal8 => Self::Normal4,
            wavelet => wavelet,
        }
    }

    /// The rate of gray of at most as many bits that stores images without colour better, or in fewer bits.
    #[cfg(feature = "encode")]
    pub(super) fn of_gray(self) -> Option<Self> {
        match self {
            Self::Color2_25 => Some(Self::Gray2),
            Self::Color3 | Self::Color3_25 => Some(Self::Gray3),
            Self::Color4 => Some(Self::Gray4),
            _ => None,
        }
    }

    /// The rate of the wavelet that the encoder considers where most of the error is that of chroma: a
    /// smaller one with more chroma.
    pub fn with_more_chroma(self) -> Option<Self> {
        (self == Self::Color3_25).then_some(Self::Color3)
    }

    /// Packings that the encoder can choose from for luma; all of them take the same size.
    pub fn luma_packings(self) -> &'static [Packing] {
        self.row().2
    }

    /// How often the size of chroma is halved, or `None` where there is no chroma.
    pub fn chroma_subsampling(self) -> Option<u32> {
        self.row().3
    }

    /// The most bits per pixel that large images take without mips. Alpha takes as many as luma; in
    /// plain textures it takes 4, or none in BC7.
    pub fn nominal_bits_per_pixel(self, alpha: bool) -> f64 {
        match self {
            Self::Gray4 => 4.0,
            Self::Color8 | Self::Normal8 => 8.0,
            wavelet => {
                let luma = wavelet.luma_packings()[0].bits_per_pixel();
                let planes = wavelet.content(alpha).luma_planes() as f64;
                let chroma = wavelet.chroma_subsampling();
                let chroma = chroma.map_or(0.0, |s| 4.0 / f64::from(1 << (2 * s)));
                planes * luma + chroma
            }
        }
    }

    /// The most bytes that the largest level of an image takes: those of the wavelet of the rate, or the
    /// nominal bits of every pixel of its 4 x 4 blocks where these are more. A small image, or one whose
    /// sides are no whole blocks, takes more than the nominal bits.
    pub fn most_bytes(self, image_size: [u32; 2], alpha: bool) -> usize {
        let group = |packing, planes, subsampling| {
            layout::group_bytes(packing, planes, layout::plane_size(image_size, subsampling))
        };
        let planes = self.content(alpha).luma_planes();
        let luma = group(self.luma_packings()[0], planes, 0);
        let chroma = self.chroma_subsampling();
        let wavelet = luma + chroma.map_or(0, |s| group(Packing::Bc1, 2, s));
        let blocks = image_size.map(|s| f64::from(s.div_ceil(4)));
        let nominal = 2.0 * self.nominal_bits_per_pixel(alpha) * blocks[0] * blocks[1];
        wavelet.max(nominal as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_say_the_bits_per_pixel() {
        for rate in Rate::ALL {
            let number = rate.name().trim_start_matches(char::is_alphabetic);
            let bits: f64 = number.parse().expect("a number");
            assert_eq!(rate.nominal_bits_per_pixel(false), bits, "{rate:?}");
            assert_eq!(Rate::from_name(rate.name()), Some(rate));
        }
        assert_eq!(Rate::Color3.nominal_bits_per_pixel(true), 5.0);
        assert_eq!(Rate::from_name("color6"), None);
    }

    #[test]
    fn bytes_are_the_nominal_bits_of_whole_blocks_and_those_of_the_wavelet() {
        for rate in Rate::ALL {
            let nominal = rate.nominal_bits_per_pixel(false) * 128.0 * 64.0 / 8.0;
            for size in [[128, 64], [127, 63]] {
                let bytes = rate.most_bytes(size, false) as f64;
                assert_eq!(bytes, nominal, "{rate:?} {size:?}");
            }
        }
        assert_eq!(Rate::Color3.most_bytes([128, 64], true), 5 * 1024);
        // A block of luma and one of chroma, and of BC7.
        assert_eq!(Rate::Color3.most_bytes([1, 3], false), 24);
        assert_eq!(Rate::Color8.most_bytes([1, 3], false), 16);
    }

    #[test]
    fn every_content_has_rates_that_grow() {
        for content in [
            Content::Gray,
            Content::Color,
            Content::ColorAlpha,
            Content::Normal,
        ] {
            let alpha = content == Content::ColorAlpha;
            let bits = Rate::of(content).map(|r| r.nominal_bits_per_pixel(alpha));
            let bits: Vec<f64> = bits.collect();
            let grow = !bits.is_empty() && bits.is_sorted();
            assert!(grow, "{content:?}: {bits:?}");
        }
    }
}

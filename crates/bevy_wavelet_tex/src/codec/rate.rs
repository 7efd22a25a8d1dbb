//! Rates: the content of an image and its bits per pixel (thesis Table 3.2, and more).

use serde::{Deserialize, Serialize};

use super::{image::Content, packing::Packing};

/// The content of an image and its bits per pixel. The numbers are those of the largest level.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Rate {
    /// Gray at 2 bpp: one wavelet plane in BC3 or BC7.
    Gray2,
    /// Gray at 3 bpp: the low band in BC4, the detail bands in BC7.
    Gray3,
    /// Colour at 2.25 bpp: luma as in [`Self::Gray2`], chroma at a quarter of the width and height.
    Color2_25,
    /// Colour at 3 bpp: luma as in [`Self::Gray2`], chroma at half the width and height.
    Color3,
    /// Colour at 3.25 bpp: luma as in [`Self::Gray3`], chroma at a quarter of the width and height.
    Color3_25,
    /// Colour at 5 bpp: luma in BC4 at full size, chroma at half the width and height.
    Color5,
    /// X and Y of normals at 4 bpp: two planes as in [`Self::Gray2`].
    Normal4,
}

impl Rate {
    /// All rates; those of one content are in ascending order of size.
    pub const ALL: [Self; 7] = [
        Self::Gray2,
        Self::Gray3,
        Self::Color2_25,
        Self::Color3,
        Self::Color3_25,
        Self::Color5,
        Self::Normal4,
    ];

    /// Name of the rate in the tool, such as `gray2` or `color2.25`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Gray2 => "gray2",
            Self::Gray3 => "gray3",
            Self::Color2_25 => "color2.25",
            Self::Color3 => "color3",
            Self::Color3_25 => "color3.25",
            Self::Color5 => "color5",
            Self::Normal4 => "normal4",
        }
    }

    /// The rate with the given name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|rate| rate.name() == name)
    }

    /// The content of the rate, with or without an alpha channel. Only colour can have one.
    pub fn content(self, alpha: bool) -> Content {
        match self {
            Self::Gray2 | Self::Gray3 => Content::Gray,
            Self::Normal4 => Content::Normal,
            _ if alpha => Content::ColorAlpha,
            _ => Content::Color,
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
        Self::ALL
            .into_iter()
            .filter(move |rate| rate.content(alpha) == content)
    }

    /// Packings that the encoder can choose from for luma; all of them take the same size.
    pub fn luma_packings(self) -> &'static [Packing] {
        match self {
            Self::Gray2 | Self::Color2_25 | Self::Color3 | Self::Normal4 => {
                &[Packing::Bc3, Packing::Bc7]
            }
            Self::Gray3 | Self::Color3_25 => &[Packing::Split],
            Self::Color5 => &[Packing::Bc4],
        }
    }

    /// How often the size of chroma is halved, or `None` where there is no chroma.
    pub fn chroma_subsampling(self) -> Option<u32> {
        match self {
            Self::Color3 | Self::Color5 => Some(1),
            Self::Color2_25 | Self::Color3_25 => Some(2),
            Self::Gray2 | Self::Gray3 | Self::Normal4 => None,
        }
    }

    /// Bits per pixel of large images without mips. Alpha takes as many bits as luma.
    pub fn nominal_bits_per_pixel(self, alpha: bool) -> f64 {
        let luma = self.luma_packings()[0].bits_per_pixel();
        let planes = self.content(alpha).luma_planes() as f64;
        let chroma = self
            .chroma_subsampling()
            .map_or(0.0, |s| 4.0 / f64::from(1 << (2 * s)));
        planes * luma + chroma
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
        assert_eq!(Rate::from_name("color4"), None);
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
            let bits: Vec<f64> = Rate::of(content)
                .map(|r| r.nominal_bits_per_pixel(alpha))
                .collect();
            assert!(
                !bits.is_empty() && bits.is_sorted(),
                "{content:?}: {bits:?}"
            );
        }
    }
}

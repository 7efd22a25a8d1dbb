//! How images are encoded when assets are processed.

use serde::{Deserialize, Serialize};

use crate::codec::{
    image::{ColorSpace, Content},
    rate::Rate,
    settings::{Effort, Formats, GrayChannel},
};

/// Settings of [`WaveletSaver`](crate::asset::WaveletSaver), which are the `saver_settings` in a `.meta` file.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct WaveletSaverSettings {
    /// The kind of data in the image. Default: [`WaveletRole::Color`].
    pub role: WaveletRole,
    /// The quality to encode at, as a rate or as a PSNR. Default: [`WaveletQuality::Usual`].
    pub quality: WaveletQuality,
    /// Whether colour keeps its alpha channel, which takes as many bits as luma. Default: `false`.
    pub alpha: bool,
    /// The `AlphaMode::Mask` cutoff of the material: mips then cover as much as the image does. Default: `None`,
    /// which is 0.5 in the role [`WaveletRole::Mask`] and otherwise leaves alpha as it is filtered.
    pub alpha_cutoff: Option<f32>,
    /// Time to spend on the search for the parameters. Default: [`Effort::Default`].
    pub effort: Effort,
    /// Whether to make mips where the image has none. Default: `true`.
    pub mips: bool,
    /// Longest side in pixels: larger images are halved until no side is longer. Default: `None`,
    /// no limit.
    pub max_size: Option<u32>,
    /// Whether to encode without prediction: a decoded pixel then takes one fetch of luma instead
    /// of five, at a lower quality. Default: `false`.
    pub one_fetch: bool,
    /// The kinds of textures to choose from, by their error. Default: [`Formats::Any`].
    pub formats: Formats,
    /// Compresses the file with Zstandard, at a level from 1 (fast) to 22 (small), which needs the feature
    /// `zstd_encode`. At level 19 the file is 11 to 20% smaller, and a game, which needs the feature `zstd`,
    /// takes 3 to 4 ms more per megapixel to load it. Default: `None`, uncompressed.
    pub zstd: Option<i32>,
}

impl Default for WaveletSaverSettings {
    fn default() -> Self {
        Self {
            role: WaveletRole::default(),
            quality: WaveletQuality::default(),
            alpha: false,
            alpha_cutoff: None,
            effort: Effort::default(),
            mips: true,
            max_size: None,
            one_fetch: false,
            formats: Formats::default(),
            zstd: None,
        }
    }
}

/// The quality of a texture, by its rate or by its error.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum WaveletQuality {
    /// The default rate of the role: 2 bits per pixel for gray, 3 for colour, 4 for normals.
    #[default]
    Usual,
    /// The given rate, which must be one of the role's.
    Rate(Rate),
    /// The smallest rate of the role that reaches this PSNR in dB, measured on the encoded image
    /// itself, or the largest rate where none does. `docs/wavelet_tex.md` of the repository lists the
    /// PSNR of each rate on photographs.
    MinPsnr(f64),
}

impl WaveletQuality {
    /// The rate to encode with, and the PSNR in dB that replaces it by the smallest sufficient one.
    pub(crate) fn goal(self, content: Content) -> (Rate, Option<f64>) {
        match self {
            Self::Usual => (Rate::usual(content), None),
            Self::Rate(rate) => (rate, None),
            Self::MinPsnr(db) => (Rate::usual(content), Some(db)),
        }
    }
}

/// The kind of data in an image, which decides its content and its transfer function.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum WaveletRole {
    /// Base colour or emissive colour, in sRGB.
    #[default]
    Color,
    /// A gray picture, in sRGB.
    Gray,
    /// A normal map in tangent space.
    Normal,
    /// A mask that cuts parts out: red, as linear data.
    Mask,
    /// One channel of linear data, which is red: occlusion.
    Occlusion,
    /// Three channels of linear data: metallic-roughness.
    Data,
}

impl WaveletRole {
    pub(crate) fn content(self) -> Content {
        match self {
            Self::Color | Self::Data => Content::Color,
            Self::Gray | Self::Mask | Self::Occlusion => Content::Gray,
            Self::Normal => Content::Normal,
        }
    }

    /// What gray is made of.
    pub(crate) fn gray(self) -> GrayChannel {
        match self {
            Self::Mask | Self::Occlusion => GrayChannel::Red,
            Self::Color | Self::Gray | Self::Normal | Self::Data => GrayChannel::Luma,
        }
    }

    /// The cutoff where none is set.
    pub(crate) fn usual_cutoff(self) -> Option<f32> {
        (self == Self::Mask).then_some(0.5)
    }

    pub(crate) fn color_space(self) -> ColorSpace {
        match self {
            Self::Color | Self::Gray => ColorSpace::Srgb,
            Self::Normal | Self::Mask | Self::Occlusion | Self::Data => ColorSpace::Linear,
        }
    }
}

//! The settings of the encoder.

use serde::{Deserialize, Serialize};

use super::{
    blocks::{BlockQuality, Starts},
    image::{ColorSpace, Content},
    rate::Rate,
};

/// Settings of [`encode`](super::encoder::encode).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EncodeSettings {
    /// The content of the image and its bits per pixel. Default: [`Rate::Color3`].
    pub rate: Rate,
    /// When set, the encoder chooses the smallest rate of the same content that reaches this PSNR
    /// in dB, or the largest rate when none does. That encodes the largest level once for each rate
    /// it tries. Default: `None`.
    pub min_psnr_db: Option<f64>,
    /// Whether colour keeps its alpha channel, which takes as many bits as luma. Default: `false`.
    pub alpha: bool,
    /// What gray is made of. Default: [`GrayChannel::Luma`].
    pub gray: GrayChannel,
    /// Where the alpha of colour, or gray, cuts parts out: the value, in `(0, 1]`, from which on a pixel is
    /// there. Mips that the encoder makes then cover as much of the image as the largest level does, which
    /// filtered alpha does not: thin leaves vanish. Default: `None`.
    pub alpha_cutoff: Option<f32>,
    /// Transfer function of the values; normals are always linear. Default: sRGB.
    pub color_space: ColorSpace,
    /// Whether to make mips where none are given, by a box filter in linear light. Default: `true`.
    pub mips: bool,
    /// Time to spend on the search for the parameters. Default: [`Effort::Default`].
    pub effort: Effort,
    /// The parts of the codec to use. Default: [`Method::Best`].
    pub method: Method,
    /// The kinds of textures to choose from. Default: [`Formats::Any`].
    pub formats: Formats,
}

/// What a gray texture is made of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum GrayChannel {
    /// Y of YCoCg, for pictures.
    #[default]
    Luma,
    /// The red channel, from which renderers read occlusion and masks.
    Red,
    /// The alpha channel.
    Alpha,
}

/// The kinds of textures that an encoder chooses from, by their error.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Formats {
    /// Wavelets, and plain BC textures of at most as many bits.
    ///
    /// [`Method::Thesis`] always encodes wavelets. See [`plain`](super::plain).
    #[default]
    Any,
    /// Wavelets alone.
    ///
    /// The shader filters them after decoding.
    Wavelet,
    /// Plain BC textures alone, at full size or smaller.
    ///
    /// They cost a shader hardly more than Bevy's own, at a lower quality. Where the sides of an image are no multiples
    /// of 4 and all of its pixels are stored, the shader filters them.
    Plain,
}

/// The parts of the codec that an encoder uses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Method {
    /// Everything that improves the quality.
    #[default]
    Best,
    /// Without prediction: one fetch of luma for a pixel instead of five.
    ///
    /// Gray at 2 bits per pixel loses 0.7 dB.
    OneFetch,
    /// The codec of the thesis.
    ///
    /// It has the partially inverted Haar transform with a search for w, clamping and power curve, and chroma in wavelet
    /// planes that are repeated instead of interpolated.
    Thesis,
}

impl EncodeSettings {
    /// The transfer function of what is stored.
    pub(super) fn stored_color_space(&self) -> ColorSpace {
        match self.rate.content(self.alpha) {
            Content::Normal => ColorSpace::Linear,
            _ => self.color_space,
        }
    }
}

impl Default for EncodeSettings {
    fn default() -> Self {
        Self {
            rate: Rate::Color3,
            min_psnr_db: None,
            alpha: false,
            gray: GrayChannel::Luma,
            alpha_cutoff: None,
            color_space: ColorSpace::Srgb,
            mips: true,
            effort: Effort::Default,
            method: Method::Best,
            formats: Formats::Any,
        }
    }
}

/// Time that the encoder spends on the search for its parameters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Effort {
    /// No search for the parameters.
    ///
    /// The encoder uses the values to which the search converges for most images. For previews.
    Fast,
    /// A search over a sample of 512 blocks.
    ///
    /// Where a rate has two packings, the better one is kept.
    #[default]
    Default,
    /// A finer search over a sample of 4096 blocks.
    Best,
}

impl Effort {
    /// The starting points of the search for the endpoints of a block.
    pub(super) fn starts(self) -> Starts {
        match self {
            Self::Fast => Starts::One,
            Self::Default => Starts::Two,
            Self::Best => Starts::Four,
        }
    }

    /// What the block encoders of other crates spend on quality.
    pub(super) fn block_quality(self) -> BlockQuality {
        match self {
            Self::Fast => BlockQuality::Normal,
            Self::Default | Self::Best => BlockQuality::High,
        }
    }
}

//! The values of options, and their parsers.

use bevy_wavelet_tex::codec::{image::Content, rate::Rate};
use clap::ValueEnum;

/// A rate, or the bits per pixel, whose rate depends on the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RateArg {
    Named(Rate),
    Bits(f64),
    Auto,
}

/// The kind of data in an image, in the order in which one of several has the image's own name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
pub enum Role {
    /// Base colour or emissive colour
    #[value(alias = "colour")]
    Color,
    /// A normal map in tangent space
    Normal,
    /// Three channels of linear data: metallic-roughness
    Data,
    /// One channel that cuts parts out: alpha where the image has its shape there, else red
    Mask,
    /// One channel of linear data, which is red: occlusion, roughness, height
    Occlusion,
    /// A gray picture
    #[value(alias = "grey")]
    Gray,
}

impl Role {
    pub fn content(self) -> Content {
        match self {
            Self::Color | Self::Data => Content::Color,
            Self::Gray | Self::Mask | Self::Occlusion => Content::Gray,
            Self::Normal => Content::Normal,
        }
    }

    /// Whether the values are linear data, not sRGB colour.
    pub fn is_linear(self) -> bool {
        !matches!(self, Self::Color | Self::Gray)
    }

    /// Whether alpha belongs to the image.
    pub fn has_alpha(self) -> bool {
        matches!(self, Self::Color | Self::Gray)
    }

    pub fn name(self) -> &'static str {
        match self {
            Self::Color => "color",
            Self::Gray => "gray",
            Self::Normal => "normal",
            Self::Mask => "mask",
            Self::Occlusion => "occlusion",
            Self::Data => "data",
        }
    }
}

/// When alpha is kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum AlphaArg {
    /// Where a picture has transparent pixels, and the glTF material uses them
    #[default]
    Auto,
    /// Where a picture has transparent pixels
    Keep,
    /// Never
    Drop,
}

/// From which alpha on a pixel is there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CutoffArg {
    At(f32),
    None,
}

pub fn parse_cutoff(text: &str) -> Result<CutoffArg, String> {
    if text == "none" {
        return Ok(CutoffArg::None);
    }
    let number = text.parse().ok().filter(|v: &f32| *v > 0.0 && *v <= 1.0);
    number
        .map(CutoffArg::At)
        .ok_or_else(|| "none, or a number above 0 and at most 1 is needed".into())
}

fn names() -> String {
    Rate::ALL.map(Rate::name).join(", ")
}

pub fn parse_named_rate(text: &str) -> Result<Rate, String> {
    Rate::from_name(text).ok_or_else(|| format!("possible are {}", names()))
}

pub fn parse_rate(text: &str) -> Result<RateArg, String> {
    if text == "auto" {
        return Ok(RateArg::Auto);
    }
    if let Some(rate) = Rate::from_name(text) {
        return Ok(RateArg::Named(rate));
    }
    let has = |bits: &f64| {
        let mut all = Rate::ALL.iter();
        all.any(|rate| rate.nominal_bits_per_pixel(false) == *bits)
    };
    let bits = text.parse().ok().filter(has);
    bits.map(RateArg::Bits)
        .ok_or_else(|| format!("possible are auto, {}, or their numbers", names()))
}

pub fn parse_psnr(text: &str) -> Result<f64, String> {
    let number = text
        .parse()
        .ok()
        .filter(|db: &f64| (0.0..=99.0).contains(db));
    number.ok_or_else(|| "a number from 0 to 99 is needed, in dB".into())
}

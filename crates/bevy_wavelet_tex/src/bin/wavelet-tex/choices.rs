//! The values of options, and their parsers.

use bevy_wavelet_tex::codec::{image::Content, rate::Rate, settings};
use clap::ValueEnum;

/// A rate, or the bits per pixel, whose rate depends on the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RateArg {
    Named(Rate),
    Bits(f64),
    Auto,
}

/// The kind of data in an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Role {
    /// Base colour or emissive colour
    #[value(alias = "colour")]
    Color,
    /// A gray picture
    #[value(alias = "grey")]
    Gray,
    /// A normal map in tangent space
    Normal,
    /// One channel of linear data: occlusion, alpha masks
    Mask,
    /// Three channels of linear data: metallic-roughness
    Data,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum Effort {
    /// No search for the parameters
    Fast,
    /// A search over a sample of the image
    Default,
    /// A finer search over a larger sample
    Best,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum Method {
    /// Everything that improves the quality
    Best,
    /// Without prediction: one fetch of luma for a pixel instead of nine
    OneFetch,
    /// The codec of the thesis
    Thesis,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum Formats {
    /// Wavelets, and plain BC textures of at most as many bits
    Any,
    /// Wavelets alone
    Wavelet,
    /// Plain BC textures alone, at full size or smaller
    Plain,
}

impl From<Formats> for settings::Formats {
    fn from(formats: Formats) -> Self {
        match formats {
            Formats::Any => Self::Any,
            Formats::Wavelet => Self::Wavelet,
            Formats::Plain => Self::Plain,
        }
    }
}

impl From<Effort> for settings::Effort {
    fn from(effort: Effort) -> Self {
        match effort {
            Effort::Fast => Self::Fast,
            Effort::Default => Self::Default,
            Effort::Best => Self::Best,
        }
    }
}

impl From<Method> for settings::Method {
    fn from(method: Method) -> Self {
        match method {
            Method::Best => Self::Best,
            Method::OneFetch => Self::OneFetch,
            Method::Thesis => Self::Thesis,
        }
    }
}

impl Role {
    pub fn content(self) -> Content {
        match self {
            Self::Color | Self::Data => Content::Color,
            Self::Gray | Self::Mask => Content::Gray,
            Self::Normal => Content::Normal,
        }
    }
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

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

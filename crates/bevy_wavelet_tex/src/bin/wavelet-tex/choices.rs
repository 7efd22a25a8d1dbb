//! The values of options, and their parsers.

use bevy_wavelet_tex::codec::{
    image::Content,
    rate::Rate,
    settings::{Effort, Formats, Method},
};
use clap::{
    ValueEnum,
    builder::{PossibleValue, PossibleValuesParser, TypedValueParser},
};

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

pub const EFFORTS: [Choice<Effort>; 3] = [
    ("fast", Effort::Fast, "No search for the parameters"),
    (
        "default",
        Effort::Default,
        "A search over a sample of the image",
    ),
    ("best", Effort::Best, "A finer search over a larger sample"),
];

pub const METHODS: [Choice<Method>; 3] = [
    ("best", Method::Best, "Everything that improves the quality"),
    (
        "one-fetch",
        Method::OneFetch,
        "Without prediction: one fetch of luma for a pixel instead of five",
    ),
    ("thesis", Method::Thesis, "The codec of the thesis"),
];

pub const FORMATS: [Choice<Formats>; 3] = [
    (
        "any",
        Formats::Any,
        "Wavelets, and plain BC textures of at most as many bits",
    ),
    ("wavelet", Formats::Wavelet, "Wavelets alone"),
    (
        "plain",
        Formats::Plain,
        "Plain BC textures alone, at full size or smaller",
    ),
];

/// A value with its name on the command line and a line of help.
type Choice<T> = (&'static str, T, &'static str);

/// A parser of the names of choices.
pub fn named<T: Clone + Send + Sync + 'static>(
    choices: &'static [Choice<T>],
) -> impl TypedValueParser<Value = T> {
    let names = choices
        .iter()
        .map(|(name, _, help)| PossibleValue::new(name).help(help));
    PossibleValuesParser::new(names).map(|name| {
        let mut choices = choices.iter();
        let choice = choices.find(|(known, ..)| *known == name);
        choice.expect("one of the possible values").1.clone()
    })
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

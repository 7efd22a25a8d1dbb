//! The command line.

use std::path::PathBuf;

use bevy_wavelet_tex::codec::{
    encoder::Method as CodecMethod,
    image::{ColorSpace, Content},
    rate::Rate,
    search,
};
use clap::{Args, Parser, Subcommand, ValueEnum};

use crate::error::Error;

/// Wavelet textures at 2 to 5 bits per pixel: encode, decode, inspect, compare, measure.
#[derive(Debug, Parser)]
#[command(name = "wavelet-tex", version)]
pub struct Cli {
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    Encode(EncodeArgs),
    Decode(DecodeArgs),
    Info(InfoArgs),
    Compare(CompareArgs),
    Bench(BenchArgs),
    Tables(TablesArgs),
    Normals(NormalsArgs),
}

/// Encode PNGs, and the PNGs inside glTF files, as wavelet textures
#[derive(Debug, Args)]
pub struct EncodeArgs {
    /// PNGs of 8 or 16 bits, glTF files, folders (all PNGs below them) and globs; a last name that
    /// ends in .wtex is the output of a single PNG
    #[arg(required = true, value_name = "INPUT")]
    pub inputs: Vec<PathBuf>,
    /// Output file, for a single PNG, or output folder [default: beside each input, with the
    /// extension wtex]
    #[arg(short, long)]
    pub out: Option<PathBuf>,
    #[command(flatten)]
    pub how: How,
    /// Store the largest level only
    #[arg(long)]
    pub no_mips: bool,
    /// Print the results as JSON
    #[arg(long)]
    pub json: bool,
}

/// Options of the encoder.
#[derive(Clone, Debug, Args)]
pub struct How {
    /// Rate: gray2, gray3, color2.25, color3, color3.25, color5, normal4, the bits per pixel alone,
    /// or auto (with --min-psnr) [default: 2 for gray PNGs, 3 for colour, 4 for normals]
    #[arg(long, value_parser = parse_rate)]
    rate: Option<RateArg>,
    /// Choose the smallest rate that reaches this PSNR in dB
    #[arg(long, value_name = "DB", value_parser = parse_psnr)]
    min_psnr: Option<f64>,
    /// Kind of data in the image [default: gray for gray PNGs, else color]
    #[arg(long, value_enum)]
    role: Option<Role>,
    /// Time to spend on the search for the parameters
    #[arg(long, value_enum, default_value_t = Effort::Default)]
    effort: Effort,
    /// Parts of the codec to use
    #[arg(long, value_enum, default_value_t = Method::Best)]
    method: Method,
    /// Treat the values as linear data, not as sRGB colour (always so for normals, masks and data)
    #[arg(long)]
    linear: bool,
    /// Keep the alpha channel of colour
    #[arg(long)]
    pub alpha: bool,
    /// Halve images until no side is longer than this, in pixels
    #[arg(long, value_name = "PIXELS", value_parser = clap::value_parser!(u32).range(1..))]
    pub max_size: Option<u32>,
}

/// Decode wavelet textures to PNGs of 8 bits
#[derive(Debug, Args)]
pub struct DecodeArgs {
    /// Textures, folders and globs; a last name that does not end in .wtex is the output of a
    /// single texture
    #[arg(required = true, value_name = "INPUT")]
    pub inputs: Vec<PathBuf>,
    /// Output PNG, for a single texture, or output folder [default: beside each input]
    #[arg(short, long)]
    pub out: Option<PathBuf>,
    /// Mip level to decode; 0 is the largest
    #[arg(long, default_value_t = 0)]
    pub level: u32,
}

/// Show what wavelet textures hold and how they are coded
#[derive(Debug, Args)]
pub struct InfoArgs {
    /// Textures, folders and globs
    #[arg(required = true, value_name = "INPUT")]
    pub inputs: Vec<PathBuf>,
    /// Print JSON: an object, or an array of them where the inputs can be several files
    #[arg(long)]
    pub json: bool,
}

/// Measure the error between two images, PNGs or wavelet textures
#[derive(Debug, Args)]
pub struct CompareArgs {
    /// The first image
    pub a: PathBuf,
    /// The second image
    pub b: PathBuf,
    /// Treat both as normal maps and report the angle, too (the default for normal textures)
    #[arg(long)]
    pub normal: bool,
    /// Print JSON; psnr_db is null when the images are identical
    #[arg(long)]
    pub json: bool,
}

/// Encode images at many rates and report quality and time; nothing is written
#[derive(Debug, Args)]
pub struct BenchArgs {
    /// PNGs, folders and globs
    #[arg(required = true, value_name = "INPUT")]
    pub inputs: Vec<PathBuf>,
    /// Rates to encode at, separated by commas [default: all of gray and colour]
    #[arg(long, value_delimiter = ',', value_parser = parse_named_rate)]
    pub rates: Vec<Rate>,
    /// Time to spend on the search for the parameters
    #[arg(long, value_enum, default_value_t = Effort::Default)]
    effort: Effort,
    /// Parts of the codec to use
    #[arg(long, value_enum, default_value_t = Method::Best)]
    method: Method,
    /// Also measure baselines (BC1, BC4 and BC7 of a lower resolution, BC formats at full size) and
    /// two levels of wavelets
    #[arg(long)]
    pub study: bool,
    /// Print a JSON array of image, rate, bpp, psnr_db (null where the images are identical) and
    /// encode_s
    #[arg(long)]
    pub json: bool,
}

/// Reproduce the thesis's Tables 3.1 and 3.3 and compare every rate with baselines of the same
/// bits, as means over the images
#[derive(Debug, Args)]
pub struct TablesArgs {
    /// PNGs, folders and globs
    #[arg(required = true, value_name = "INPUT")]
    pub inputs: Vec<PathBuf>,
    /// Print JSON instead of Markdown
    #[arg(long)]
    pub json: bool,
}

/// Measure the angular error of normal maps in wavelet textures, BC5 and BC1, for a smooth and a
/// rough generated map and for the given ones
#[derive(Debug, Args)]
pub struct NormalsArgs {
    /// PNGs, folders and globs
    #[arg(value_name = "INPUT")]
    pub inputs: Vec<PathBuf>,
    /// Also write a PNG of a highlight on the smooth map, from left to right exact, in BC1, in BC5
    /// and as a wavelet texture, and below each the difference from exact, amplified ten times
    /// (thesis Fig. 3.24)
    #[arg(long, value_name = "PNG")]
    pub picture: Option<PathBuf>,
    /// Print JSON instead of Markdown
    #[arg(long)]
    pub json: bool,
}

/// A rate, or the bits per pixel, whose rate depends on the image.
#[derive(Clone, Copy, Debug, PartialEq)]
enum RateArg {
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
enum Effort {
    /// No search for the parameters
    Fast,
    /// A search over a sample of the image
    Default,
    /// A finer search over a larger sample
    Best,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Method {
    /// Everything that improves the quality
    Best,
    /// Without prediction: one fetch of luma for a pixel instead of nine
    OneFetch,
    /// The codec of the thesis
    Thesis,
}

/// The resolved request for one image.
#[derive(Clone, Copy, Debug)]
pub struct Wish {
    pub rate: Rate,
    pub min_psnr_db: Option<f64>,
    pub linear: bool,
}

impl Wish {
    pub fn color_space(self) -> ColorSpace {
        if self.linear {
            ColorSpace::Linear
        } else {
            ColorSpace::Srgb
        }
    }
}

impl How {
    /// Resolves the arguments for an image. `role` overrides the role on the command line.
    pub fn wish(&self, image_is_gray: bool, role: Option<Role>) -> Result<Wish, Error> {
        let role = role.or(self.role);
        let by_rate = match self.rate {
            Some(RateArg::Named(rate)) => Some(rate.content(false)),
            Some(RateArg::Bits(4.0)) => Some(Content::Normal),
            Some(RateArg::Bits(2.0)) => Some(Content::Gray),
            Some(RateArg::Bits(3.0)) if image_is_gray => Some(Content::Gray),
            Some(RateArg::Bits(_)) => Some(Content::Color),
            Some(RateArg::Auto) | None => None,
        };
        let content = match role {
            Some(role) => role.content(),
            None => by_rate.unwrap_or(if image_is_gray {
                Content::Gray
            } else {
                Content::Color
            }),
        };
        let rate = match self.rate {
            Some(RateArg::Named(rate)) if rate.content(false) == content => rate,
            Some(RateArg::Bits(bits)) => Rate::of(content)
                .find(|rate| rate.nominal_bits_per_pixel(false) == bits)
                .ok_or_else(|| self.no_such_rate(content))?,
            Some(RateArg::Named(_)) => return Err(self.no_such_rate(content)),
            Some(RateArg::Auto) | None => Rate::usual(content),
        };
        Ok(Wish {
            rate,
            min_psnr_db: self.min_psnr,
            linear: self.linear
                || content == Content::Normal
                || matches!(role, Some(Role::Mask | Role::Data)),
        })
    }

    /// Returns an error when the arguments contradict each other, before any image is read.
    pub fn check(&self) -> Result<(), Error> {
        match (self.rate, self.min_psnr) {
            (Some(RateArg::Auto), None) => Err(Error::Usage(
                "--rate auto needs --min-psnr: set the PSNR to reach".into(),
            )),
            (Some(RateArg::Named(_) | RateArg::Bits(_)), Some(_)) => Err(Error::Usage(
                "--min-psnr chooses the rate: leave --rate away, or use --rate auto".into(),
            )),
            _ => match self.role {
                Some(role) => self.wish(false, Some(role)).map(|_| ()),
                None => Ok(()),
            },
        }
    }

    fn no_such_rate(&self, content: Content) -> Error {
        let rate = match self.rate {
            Some(RateArg::Named(rate)) => rate.name().to_string(),
            Some(RateArg::Bits(bits)) => bits.to_string(),
            Some(RateArg::Auto) | None => "auto".into(),
        };
        let possible: Vec<_> = Rate::of(content).map(Rate::name).collect();
        Error::Usage(format!(
            "{} cannot be coded at {rate} bits per pixel; possible are {}",
            name(content),
            possible.join(", "),
        ))
    }

    pub fn effort(&self) -> search::Effort {
        self.effort.into()
    }

    pub fn method(&self) -> CodecMethod {
        self.method.into()
    }
}

impl BenchArgs {
    pub fn effort(&self) -> search::Effort {
        self.effort.into()
    }

    pub fn method(&self) -> CodecMethod {
        self.method.into()
    }
}

impl From<Effort> for search::Effort {
    fn from(effort: Effort) -> Self {
        match effort {
            Effort::Fast => Self::Fast,
            Effort::Default => Self::Default,
            Effort::Best => Self::Best,
        }
    }
}

impl From<Method> for CodecMethod {
    fn from(method: Method) -> Self {
        match method {
            Method::Best => Self::Best,
            Method::OneFetch => Self::OneFetch,
            Method::Thesis => Self::Thesis,
        }
    }
}

impl Role {
    fn content(self) -> Content {
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

fn parse_named_rate(text: &str) -> Result<Rate, String> {
    Rate::from_name(text).ok_or_else(|| format!("possible are {}", names()))
}

fn parse_rate(text: &str) -> Result<RateArg, String> {
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

fn parse_psnr(text: &str) -> Result<f64, String> {
    let number = text
        .parse()
        .ok()
        .filter(|db: &f64| (0.0..=99.0).contains(db));
    number.ok_or_else(|| "a number from 0 to 99 is needed, in dB".into())
}

/// Name of a content on the command line and in the JSON.
pub fn name(content: Content) -> &'static str {
    match content {
        Content::Gray => "gray",
        Content::Color => "color",
        Content::ColorAlpha => "color_alpha",
        Content::Normal => "normal",
    }
}

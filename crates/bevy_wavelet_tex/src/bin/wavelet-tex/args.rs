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
    /// A file, for a single PNG, or a folder [default: beside each input, with the extension wtex]
    #[arg(short, long)]
    pub out: Option<PathBuf>,
    #[command(flatten)]
    pub how: How,
    /// Store the largest level only
    #[arg(long)]
    pub no_mips: bool,
    /// Results as JSON
    #[arg(long)]
    pub json: bool,
}

/// How to encode.
#[derive(Clone, Debug, Args)]
pub struct How {
    /// gray2, gray3, color2.25, color3, color3.25, color5, normal4, or the number alone, or auto
    /// (with --min-psnr) [default: 2 for gray PNGs, 3 for colour, 4 for normals]
    #[arg(long, value_parser = parse_rate)]
    rate: Option<RateArg>,
    /// The smallest rate that reaches this PSNR in dB
    #[arg(long, value_name = "DB", value_parser = parse_psnr)]
    min_psnr: Option<f64>,
    /// What the image holds [default: gray for gray PNGs, else color]
    #[arg(long, value_enum)]
    role: Option<Role>,
    /// How long to search for the parameters
    #[arg(long, value_enum, default_value_t = Effort::Default)]
    effort: Effort,
    /// What the codec is made of
    #[arg(long, value_enum, default_value_t = Method::Best)]
    method: Method,
    /// The values are data, not sRGB colour; normals, masks and data always are
    #[arg(long)]
    linear: bool,
    /// Keep the alpha channel of colour
    #[arg(long)]
    pub alpha: bool,
    /// Halve images until no side is longer, in pixels
    #[arg(long, value_name = "PIXELS", value_parser = clap::value_parser!(u32).range(1..))]
    pub max_size: Option<u32>,
}

/// Decode wavelet textures to PNGs of 8 bits
#[derive(Debug, Args)]
pub struct DecodeArgs {
    /// Textures, folders and globs; a last name that ends otherwise is the output of a single one
    #[arg(required = true, value_name = "INPUT")]
    pub inputs: Vec<PathBuf>,
    /// A PNG, for a single texture, or a folder [default: beside each input]
    #[arg(short, long)]
    pub out: Option<PathBuf>,
    /// Mip level, 0 the largest
    #[arg(long, default_value_t = 0)]
    pub level: u32,
}

/// Show what wavelet textures hold and how they are coded
#[derive(Debug, Args)]
pub struct InfoArgs {
    /// Textures, folders and globs
    #[arg(required = true, value_name = "INPUT")]
    pub inputs: Vec<PathBuf>,
    /// As JSON: an object, or an array of them where there may be several
    #[arg(long)]
    pub json: bool,
}

/// Measure how far two images, PNG or wavelet texture, are apart
#[derive(Debug, Args)]
pub struct CompareArgs {
    /// The first
    pub a: PathBuf,
    /// The second
    pub b: PathBuf,
    /// Both are normal maps: report the angle too (a normal texture says so by itself)
    #[arg(long)]
    pub normal: bool,
    /// As JSON; psnr_db is null when the images are identical
    #[arg(long)]
    pub json: bool,
}

/// Encode images at many rates and report quality and time; nothing is written
#[derive(Debug, Args)]
pub struct BenchArgs {
    /// PNGs, folders and globs
    #[arg(required = true, value_name = "INPUT")]
    pub inputs: Vec<PathBuf>,
    /// Rates, separated by commas [default: all of gray and colour]
    #[arg(long, value_delimiter = ',', value_parser = parse_named_rate)]
    pub rates: Vec<Rate>,
    /// How long to search for the parameters
    #[arg(long, value_enum, default_value_t = Effort::Default)]
    effort: Effort,
    /// What the codec is made of
    #[arg(long, value_enum, default_value_t = Method::Best)]
    method: Method,
    /// Also what the rates compete with (BC1 and BC4 of a lower resolution, BC formats at full size),
    /// and two levels of wavelets
    #[arg(long)]
    pub study: bool,
    /// As a JSON array of image, rate, bpp, psnr_db (null for no error) and encode_s
    #[arg(long)]
    pub json: bool,
}

/// Rebuild the thesis's Tables 3.1 and 3.3 and set every rate beside what takes the same bits, as
/// means over the images
#[derive(Debug, Args)]
pub struct TablesArgs {
    /// PNGs, folders and globs
    #[arg(required = true, value_name = "INPUT")]
    pub inputs: Vec<PathBuf>,
    /// As JSON instead of Markdown
    #[arg(long)]
    pub json: bool,
}

/// Measure the angular error of normal maps beside BC5 and BC1, of smooth and rough generated maps and
/// of those given
#[derive(Debug, Args)]
pub struct NormalsArgs {
    /// PNGs, folders and globs
    #[arg(value_name = "INPUT")]
    pub inputs: Vec<PathBuf>,
    /// Also a PNG of a highlight on the smooth map: exact, BC1, BC5 and ours, and below them how much
    /// brighter or darker than exact they are, ten times (thesis Fig. 3.24)
    #[arg(long, value_name = "PNG")]
    pub picture: Option<PathBuf>,
    /// As JSON instead of Markdown
    #[arg(long)]
    pub json: bool,
}

/// A rate, or the bits per pixel whose meaning hangs on the image.
#[derive(Clone, Copy, Debug, PartialEq)]
enum RateArg {
    Named(Rate),
    Bits(f64),
    Auto,
}

/// What an image holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Role {
    /// Base colour, emissive
    #[value(alias = "colour")]
    Color,
    /// A gray picture
    #[value(alias = "grey")]
    Gray,
    /// A normal map in tangent space
    Normal,
    /// One channel of data: occlusion, alpha masks
    Mask,
    /// Three channels of data: metallic-roughness
    Data,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Effort {
    /// No search
    Fast,
    /// A search over a sample of the image
    Default,
    /// A finer search over a larger sample
    Best,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Method {
    /// All that pays
    Best,
    /// Without prediction: one fetch of luma for a pixel instead of nine
    OneFetch,
    /// As in the thesis
    Thesis,
}

/// What is to be encoded, of one image.
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
    /// What the role and the image make of the arguments.
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

    /// Whether the arguments make sense together, before any image is read.
    pub fn check(&self) -> Result<(), Error> {
        match (self.rate, self.min_psnr) {
            (Some(RateArg::Auto), None) => Err(Error::Usage(
                "--rate auto needs --min-psnr: which quality is wanted?".into(),
            )),
            (Some(RateArg::Named(_) | RateArg::Bits(_)), Some(_)) => Err(Error::Usage(
                "--min-psnr chooses the rate: leave --rate away, or say --rate auto".into(),
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
    number.ok_or_else(|| "a number of 0 to 99 is needed, in dB".into())
}

/// A content as the command line and the JSON call it.
pub fn name(content: Content) -> &'static str {
    match content {
        Content::Gray => "gray",
        Content::Color => "color",
        Content::ColorAlpha => "color_alpha",
        Content::Normal => "normal",
    }
}

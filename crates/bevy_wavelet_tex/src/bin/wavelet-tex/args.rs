//! The command line, and the values of its options.

use std::path::PathBuf;

use bevy_wavelet_tex::codec::{
    image::Content,
    rate::Rate,
    settings::{Effort, EncodeSettings, Formats, Method},
};
use clap::{Args, Parser, Subcommand, ValueEnum};

/// Wavelet textures at 2 to 5 bits per pixel: encode, decode, inspect, compare, measure.
#[derive(Debug, Parser)]
#[command(name = "wavelet-tex", version)]
pub struct Cli {
    #[command(subcommand)]
    pub command: Command,
    /// Threads that work at a time [default: one for each core]
    #[arg(long, global = true, value_name = "COUNT", value_parser = clap::value_parser!(u16).range(1..))]
    pub threads: Option<u16>,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    Encode(EncodeArgs),
    Decode(DecodeArgs),
    Info(InfoArgs),
    Compare(CompareArgs),
    Bench(BenchArgs),
}

/// Encode images, and the images inside glTF files, as wavelet textures
#[derive(Debug, Args)]
pub struct EncodeArgs {
    /// Images (PNG of 8 or 16 bits, JPEG, WebP, TGA, KTX2 of 8 bits a channel), glTF files, folders (all
    /// of these below them) and globs; a last name that ends in .wtex is the output of a single image
    #[arg(required = true, value_name = "INPUT")]
    pub inputs: Vec<PathBuf>,
    /// Output file, for a single image, or output folder [default: beside each input, with the
    /// extension wtex]
    #[arg(short, long)]
    pub out: Option<PathBuf>,
    /// Encode again what has not changed, and overwrite files that wavelet-tex did not write; inputs are
    /// never overwritten
    #[arg(long)]
    pub force: bool,
    /// Rates, separated by commas, each for images of its kind: gray2, gray3, gray4, color2.25, color3, color3.25,
    /// color4, color5, color8, normal4, normal8, the bits per pixel alone, or auto (with --min-psnr)
    /// [default: 2 for gray images, 3 for colour, 4 for normals]
    #[arg(long, value_delimiter = ',', value_parser = parse_rate)]
    pub rate: Vec<RateArg>,
    /// Choose the smallest rate that reaches this PSNR in dB
    #[arg(long, value_name = "DB", value_parser = parse_psnr)]
    pub min_psnr: Option<f64>,
    /// Kind of data in images that no glTF file uses [default: what their names say (wall_n, wall_normal,
    /// wall_orm, wall_ao, ...), else gray for gray images and color for others]
    #[arg(long, value_enum)]
    pub role: Option<Role>,
    /// File with roles by name: lines of a pattern and a role, such as `*_detail.png data`
    #[arg(long, value_name = "FILE")]
    pub roles: Option<PathBuf>,
    #[command(flatten)]
    pub encoder: EncoderArgs,
    /// Treat the values as linear data, not as sRGB colour (always so for normals, masks, occlusion and
    /// data, and for KTX2 in a linear format)
    #[arg(long)]
    pub linear: bool,
    /// When to keep the alpha channel of pictures; --alpha alone means keep
    #[arg(long, value_enum, value_name = "WHEN", num_args = 0..=1, require_equals = true,
          default_value = "auto", default_missing_value = "keep")]
    pub alpha: AlphaArg,
    /// Alpha from which on a pixel is there, in materials that cut parts out: mips cover as much as the image.
    /// none leaves alpha as it is filtered [default: that of the glTF material; 0.5 for masks, and for pictures
    /// with hardly any alpha between 0 and 1]
    #[arg(long, value_name = "ALPHA", value_parser = parse_cutoff)]
    pub cutoff: Option<CutoffArg>,
    /// Halve images until no side is longer than this, in pixels
    #[arg(long, value_name = "PIXELS", value_parser = clap::value_parser!(u32).range(1..))]
    pub max_size: Option<u32>,
    /// Store the largest level only
    #[arg(long)]
    pub no_mips: bool,
    /// Compress the files with Zstandard, at a level from 1 (fast) to 22 (small); games read them with the
    /// feature zstd of bevy_wavelet_tex
    #[arg(long, value_name = "LEVEL", num_args = 0..=1, require_equals = true, default_missing_value = "19",
          value_parser = clap::value_parser!(i32).range(1..=22))]
    pub zstd: Option<i32>,
    /// Print the results as JSON
    #[arg(long)]
    pub json: bool,
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
    /// Overwrite files that wavelet-tex did not write
    #[arg(long)]
    pub force: bool,
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

/// Measure the error between two images or wavelet textures
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
    /// Images, folders and globs
    #[arg(required = true, value_name = "INPUT")]
    pub inputs: Vec<PathBuf>,
    /// Rates to encode at, separated by commas [default: all of gray and colour]
    #[arg(long, value_delimiter = ',', value_parser = parse_named_rate)]
    pub rates: Vec<Rate>,
    #[command(flatten)]
    pub encoder: EncoderArgs,
    /// Print a JSON array with a row for each image and rate; a PSNR is null where the images are
    /// identical
    #[arg(long)]
    pub json: bool,
}

/// How the encoder works.
#[derive(Clone, Copy, Debug, Args)]
pub struct EncoderArgs {
    /// Time to spend on the search for the parameters
    #[arg(long, value_enum, default_value_t)]
    pub effort: Effort,
    /// Parts of the codec to use
    #[arg(long, value_enum, default_value_t)]
    pub method: Method,
    /// Kinds of textures to choose from, by their error
    #[arg(long, value_enum, default_value_t)]
    pub formats: Formats,
}

impl EncoderArgs {
    pub fn settings(self) -> EncodeSettings {
        EncodeSettings {
            effort: self.effort,
            method: self.method,
            formats: self.formats,
            ..EncodeSettings::default()
        }
    }
}

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

fn parse_cutoff(text: &str) -> Result<CutoffArg, String> {
    if text == "none" {
        return Ok(CutoffArg::None);
    }
    let number = text.parse().ok().filter(|v: &f32| *v > 0.0 && *v <= 1.0);
    number
        .map(CutoffArg::At)
        .ok_or_else(|| "none, or a number above 0 and at most 1 is needed".into())
}

fn rate_names() -> String {
    Rate::ALL.map(Rate::name).join(", ")
}

fn parse_named_rate(text: &str) -> Result<Rate, String> {
    Rate::from_name(text).ok_or_else(|| format!("possible are {}", rate_names()))
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
        .ok_or_else(|| format!("possible are auto, {}, or their numbers", rate_names()))
}

fn parse_psnr(text: &str) -> Result<f64, String> {
    let number = text
        .parse()
        .ok()
        .filter(|db: &f64| (0.0..=99.0).contains(db));
    number.ok_or_else(|| "a number from 0 to 99 is needed, in dB".into())
}

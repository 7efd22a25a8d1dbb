//! The command line.

use std::path::PathBuf;

use bevy_wavelet_tex::codec::{image::Content, search};
use clap::{Args, Parser, Subcommand, ValueEnum};

use crate::error::Error;

/// Wavelet textures at 2 to 4 bits per pixel: encode, decode, inspect, compare.
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
}

/// Encode a PNG as a wavelet texture
#[derive(Debug, Args)]
pub struct EncodeArgs {
    /// The image, a PNG of 8 or 16 bits; alpha is dropped
    pub input: PathBuf,
    /// The texture [default: the image's name with the extension wtex]
    pub output: Option<PathBuf>,
    /// Bits per pixel: 2 (gray2), 3 (color3) or 4 (normal4) [default: 2 for gray PNGs, else 3]
    #[arg(long, value_parser = parse_rate)]
    rate: Option<Content>,
    /// What the image holds; a role has one rate [default: that of the rate]
    #[arg(long)]
    role: Option<Role>,
    /// How long to search for the parameters
    #[arg(long, value_enum, default_value_t = Effort::Default)]
    effort: Effort,
    /// Store the largest level only
    #[arg(long)]
    pub no_mips: bool,
    /// The values are data (masks), not sRGB colour; normals always are
    #[arg(long)]
    pub linear: bool,
}

/// Decode a wavelet texture to a PNG of 8 bits
#[derive(Debug, Args)]
pub struct DecodeArgs {
    /// The texture
    pub input: PathBuf,
    /// The image; gray textures become gray PNGs
    pub output: PathBuf,
    /// Mip level, 0 the largest
    #[arg(long, default_value_t = 0)]
    pub level: u32,
}

/// Show what a wavelet texture holds and how it is coded
#[derive(Debug, Args)]
pub struct InfoArgs {
    /// The texture
    pub file: PathBuf,
    /// As JSON
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

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Role {
    #[value(alias = "colour")]
    Color,
    #[value(alias = "grey")]
    Gray,
    Normal,
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

impl EncodeArgs {
    /// What to encode the image as.
    pub fn content(&self, image_is_gray: bool) -> Content {
        let from_image = if image_is_gray {
            Content::Gray
        } else {
            Content::Color
        };
        self.role
            .map(Role::content)
            .or(self.rate)
            .unwrap_or(from_image)
    }

    /// Whether the role has that rate.
    pub fn check(&self) -> Result<(), Error> {
        match (self.role.map(Role::content), self.rate) {
            (Some(role), Some(rate)) if role != rate => Err(Error::Usage(format!(
                "{}: the role {} cannot be coded at {} bits per pixel; possible are {POSSIBLE}",
                self.input.display(),
                name(role),
                rate.nominal_bits_per_pixel(),
            ))),
            _ => Ok(()),
        }
    }

    pub fn effort(&self) -> search::Effort {
        match self.effort {
            Effort::Fast => search::Effort::Fast,
            Effort::Default => search::Effort::Default,
            Effort::Best => search::Effort::Best,
        }
    }
}

impl Role {
    fn content(self) -> Content {
        match self {
            Self::Color => Content::Color,
            Self::Gray => Content::Gray,
            Self::Normal => Content::Normal,
        }
    }
}

const POSSIBLE: &str = "2 (gray2) for gray, 3 (color3) for color, 4 (normal4) for normal maps";

fn parse_rate(rate: &str) -> Result<Content, String> {
    match rate {
        "2" | "gray2" => Ok(Content::Gray),
        "3" | "color3" => Ok(Content::Color),
        "4" | "normal4" => Ok(Content::Normal),
        _ => Err(format!("possible are {POSSIBLE}")),
    }
}

/// A content as the command line and the JSON call it.
pub fn name(content: Content) -> &'static str {
    match content {
        Content::Gray => "gray",
        Content::Color => "color",
        Content::Normal => "normal",
    }
}

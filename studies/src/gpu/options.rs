//! The command line.

use std::{fmt, path::PathBuf, str::FromStr};

use clap::Parser;

/// The command line of `tradeoff gpu`.
#[derive(Clone, Debug, Parser)]
#[command(name = "tradeoff gpu")]
pub struct Options {
    /// Folder in which the adapter gets a folder of its own.
    #[arg(long, value_name = "DIR", default_value = "target/tradeoff")]
    pub out: PathBuf,
    /// Size of the pictures in pixels.
    #[arg(long, value_name = "WxH", default_value = "1920x1080")]
    pub size: Size,
    /// Coinciding layers of the fill rate: more where a GPU is fast.
    #[arg(long, value_name = "N", default_value_t = 32)]
    pub layers: usize,
    /// Voxels along an edge of the volumes of light.
    #[arg(long, value_name = "N,..", value_delimiter = ',', default_values_t = [32, 64, 128],
        value_parser = clap::value_parser!(u32).range(8..=128))]
    pub resolutions: Vec<u32>,
    /// Rounds of each interleaved benchmark.
    #[arg(long, value_name = "N", default_value_t = 5)]
    pub rounds: u32,
    /// Frames of a setting in a round.
    #[arg(long, value_name = "N", default_value_t = 15)]
    pub frames: u32,
    /// Begins nothing new after this time.
    #[arg(long, value_name = "N", default_value_t = 8.0)]
    pub minutes: f64,
    /// Measures nothing: renews the tables in the plugins' pages from this file.
    #[arg(long, value_name = "FILE")]
    pub advise: Option<PathBuf>,
}

/// Width and height.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size(pub [u32; 2]);

impl fmt::Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{} x {} pixels", self.0[0], self.0[1])
    }
}

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let sides = text.split_once('x').map(|(w, h)| (w.parse(), h.parse()));
        match sides {
            Some((Ok(width), Ok(height))) if width > 0 && height > 0 => Ok(Self([width, height])),
            _ => Err("such as 1920x1080".into()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_size_has_two_sides() {
        assert_eq!("160x90".parse(), Ok(Size([160, 90])));
        assert!("160".parse::<Size>().is_err() && "0x4".parse::<Size>().is_err());
    }
}

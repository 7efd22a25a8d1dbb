//! The studies of given images and models: `tradeoff wavelet_tex rivals`, `sizes` and `materials`.
//!
//! | module | contents |
//! | --- | --- |
//! | `rivals` | colour images beside BC1, smaller BC1 textures and BC7 |
//! | `sizes` | the bytes of files on disk, and the time to read them |
//! | `materials` | the maps of a glTF file's materials together, beside BC textures |
//! | `encoded` | the texture of an image |
//! | `lit_material`, `shading` | the picture of these maps under lights |

mod encoded;
mod lit_material;
mod materials;
mod rivals;
mod shading;
mod sizes;

use std::{
    ffi::{OsStr, OsString},
    path::PathBuf,
    process::ExitCode,
};

use bevy_wavelet_tex::codec::image::ColorSpace;
use clap::{CommandFactory, Parser};
use image::DynamicImage;

use super::inputs::files;
use crate::{subcommand::subcommand, tradeoff::study::TradeoffError};

/// Measures given images or models; nothing is written.
#[derive(Clone, Debug, Parser)]
#[command(name = "tradeoff wavelet_tex")]
enum Options {
    /// Colour images beside BC1, smaller BC1 textures and BC7.
    Rivals {
        /// PNGs and JPEGs, and folders of them.
        #[arg(required = true)]
        images: Vec<PathBuf>,
        /// Treats the values as linear data, not as sRGB colour.
        #[arg(long)]
        linear: bool,
    },
    /// The bytes of files on disk, and the time to read wavelet textures.
    Sizes {
        /// Folders of PNGs and JPEGs, or of textures that `wavelet-tex encode` made of them.
        #[arg(required = true)]
        folders: Vec<PathBuf>,
    },
    /// The bits of all maps of a material together, and its picture under lights, beside BC textures.
    Materials {
        /// A glTF file with PNGs and JPEGs.
        model: PathBuf,
        /// Chooses the smallest rate of each map that reaches this PSNR in dB.
        #[arg(long, value_name = "DB")]
        min_psnr: Option<f64>,
    },
}

/// Whether a word after `tradeoff wavelet_tex` names one of these studies.
pub fn is_word(word: &OsStr) -> bool {
    Options::command().find_subcommand(word).is_some()
}

/// The `main` of these studies, with the arguments after `wavelet_tex`.
pub fn run(arguments: impl Iterator<Item = OsString>) -> ExitCode {
    subcommand("tradeoff wavelet_tex", arguments, |options: &Options| {
        println!("{}", options.table()?);
        Ok::<_, TradeoffError>(())
    })
}

impl Options {
    fn table(&self) -> Result<String, TradeoffError> {
        match self {
            Self::Rivals { images, linear } => {
                let color_space = match linear {
                    true => ColorSpace::Linear,
                    false => ColorSpace::Srgb,
                };
                rivals::tables(&read(images)?, color_space)
            }
            Self::Sizes { folders } => sizes::table(folders),
            Self::Materials { model, min_psnr } => materials::table(model, *min_psnr),
        }
    }
}

/// Reads images by their names, and those in folders.
fn read(paths: &[PathBuf]) -> Result<Vec<(String, DynamicImage)>, TradeoffError> {
    let mut images = Vec::new();
    for path in paths {
        let found = match path.is_dir() {
            true => files(path, &["png", "jpg", "jpeg"])?,
            false => vec![path.clone()],
        };
        for path in found {
            let name = path.file_stem().unwrap_or_default().to_string_lossy();
            let image = image::open(&path).map_err(TradeoffError::file(&path))?;
            images.push((name.into_owned(), image));
        }
    }
    Ok(images)
}

#[cfg(test)]
mod tests;

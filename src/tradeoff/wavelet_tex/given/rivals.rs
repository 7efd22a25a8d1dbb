//! Colour images beside BC1, smaller BC1 textures of the same bits, and BC7.

use std::fmt::Write;

use bevy_wavelet_tex::codec::{
    blocks::BlockFormat,
    image::ColorSpace,
    plain::PlainTexture,
    rate::Rate,
    settings::{EncodeSettings, Formats},
};
use image::{DynamicImage, Rgb32FImage, buffer::ConvertBuffer, imageops};

use super::{
    super::baselines::{Through, through},
    encoded::encoded,
};
use crate::{
    metrics::{
        SizeMismatch,
        error::{mse, psnr_db},
    },
    tradeoff::study::TradeoffError,
};

pub(super) const RATES: [Rate; 4] = [Rate::Color2_25, Rate::Color3, Rate::Color3_25, Rate::Color5];

/// One image at one rate.
struct Row<'a> {
    image: &'a str,
    /// What the encoder chose: the packing of luma, or the format and size of a plain texture.
    chosen: String,
    /// Bits per pixel of the largest level.
    bpp: f64,
    /// PSNR in dB, infinite where the images are identical: with the chosen texture; with wavelets alone; with
    /// BC1; with a smaller BC1 texture of at most the rate's bits, magnified by a bicubic filter (BC7 above 4 bpp);
    /// with BC7.
    psnr_db: [f64; 5],
}

/// A table for each rate: the images, their means, and the least that ours are above each other.
pub(super) fn tables(
    images: &[(String, DynamicImage)],
    color_space: ColorSpace,
) -> Result<String, TradeoffError> {
    let images = images.iter();
    let rows = images.map(|(name, image)| rows(name, image, color_space));
    let rows = rows.collect::<Result<Vec<_>, _>>()?;
    let mut text = String::new();
    for (i, rate) in RATES.iter().enumerate() {
        let rows: Vec<&Row> = rows.iter().map(|rows| &rows[i]).collect();
        text += &table(rate.name(), &rows);
    }
    Ok(text)
}

fn rows<'a>(
    name: &'a str,
    image: &DynamicImage,
    color_space: ColorSpace,
) -> Result<[Row<'a>; 4], TradeoffError> {
    let original = image.to_rgb8().convert();
    let full_size = |format| psnr(&original, &through(format, &original).decoded);
    let bc1_db = full_size(BlockFormat::Bc1)?;
    let bc7_db = full_size(BlockFormat::Bc7)?;
    let row = |rate: Rate| {
        let settings = EncodeSettings {
            rate,
            color_space,
            mips: false,
            ..EncodeSettings::default()
        };
        let (texture, here_db) = encoded(image, &settings)?;
        let wavelet = EncodeSettings {
            formats: Formats::Wavelet,
            ..settings
        };
        let (_, wavelet_db) = encoded(image, &wavelet)?;
        let bytes = rate.most_bytes(texture.size, false);
        let format = match rate.nominal_bits_per_pixel(false) {
            ..=4.0 => BlockFormat::Bc1,
            _ => BlockFormat::Bc7,
        };
        let scaled_db = psnr(&original, &scaled(&original, format, bytes))?;
        Ok::<_, TradeoffError>(Row {
            image: name,
            chosen: texture.storage_name(),
            bpp: texture.bits_per_pixel(),
            psnr_db: [here_db, wavelet_db, bc1_db, scaled_db, bc7_db],
        })
    };
    let [a, b, c, d] = RATES.map(row);
    Ok([a?, b?, c?, d?])
}

/// What a texture of whole blocks and at most these bytes shows, downsampled by Lanczos and magnified by
/// Catmull-Rom where it must be smaller. Black where not a block fits.
fn scaled(picture: &Rgb32FImage, format: BlockFormat, bytes: usize) -> Rgb32FImage {
    let (width, height) = picture.dimensions();
    match PlainTexture::sizes_within([width, height], format, bytes).first() {
        None => Rgb32FImage::new(width, height),
        Some(&size) if size == PlainTexture::full_size([width, height]) => {
            through(format, picture).decoded
        }
        Some(&[w, h]) => {
            let small = imageops::resize(picture, w, h, imageops::FilterType::Lanczos3);
            let Through { decoded, .. } = through(format, &small);
            imageops::resize(&decoded, width, height, imageops::FilterType::CatmullRom)
        }
    }
}

/// PSNR in dB, with both rounded to 8 bits.
fn psnr(a: &Rgb32FImage, b: &Rgb32FImage) -> Result<f64, SizeMismatch> {
    Ok(psnr_db(mse(&a.convert(), &b.convert())?))
}

fn table(rate: &str, rows: &[&Row]) -> String {
    let mut text = format!(
        "| {rate} | here | wavelet | BC1 | scaled | BC7 | chosen |\n\
         | --- | --- | --- | --- | --- | --- | --- |\n"
    );
    let mut line = |name: &str, figures: [f64; 5], end: &str| {
        let cells = figures.map(|figure| format!("{figure:.2}")).join(" | ");
        let _ = writeln!(text, "| {name} | {cells} | {end} |");
    };
    for row in rows {
        let end = format!("{} {:.2} bpp", row.chosen, row.bpp);
        line(row.image, row.psnr_db, &end);
    }
    let column = |i: usize| rows.iter().map(move |row| row.psnr_db[i]);
    let mean = |i| {
        let finite: Vec<f64> = column(i).filter(|psnr| psnr.is_finite()).collect();
        finite.iter().sum::<f64>() / finite.len() as f64
    };
    line("mean", std::array::from_fn(mean), "");
    let least_above = |i| {
        let above = column(0).zip(column(i)).map(|(here, other)| here - other);
        above.filter(|v| !v.is_nan()).fold(f64::INFINITY, f64::min)
    };
    line("least above", std::array::from_fn(least_above), "");
    text + "\n"
}

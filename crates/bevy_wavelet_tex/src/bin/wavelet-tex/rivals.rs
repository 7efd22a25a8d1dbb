//! The command `wavelet-tex rivals`.

use std::collections::BTreeMap;

use bevy_wavelet_tex::codec::{
    blocks::{BlockFormat, BlockQuality, Texel, decode_blocks, encode_bc1, encode_bc7},
    encoder::encode,
    image::{ColorSpace, Content},
    plain::PlainTexture,
    quality::{psnr_db, psnr_of},
    rate::Rate,
    settings::{EncodeSettings, Formats},
    source::Source,
};
use image::{Rgb, Rgb32FImage, imageops};
use serde::Serialize;

use crate::{args::RivalsArgs, batch, error::Error, picture::Picture, report::Report};

/// The PSNR in dB of one image at one rate, infinite where the images are identical (which JSON writes
/// as null).
#[derive(Serialize)]
struct Row {
    image: String,
    rate: &'static str,
    /// What the encoder chose: the packing of luma, or the format and size of a plain texture.
    chosen: String,
    /// Bits per pixel of the largest level.
    bpp: f64,
    psnr_db: f64,
    /// With wavelets alone.
    wavelet_db: f64,
    /// BC1 at 4 bpp, with a texel for each pixel.
    bc1_db: f64,
    /// A smaller BC1 texture of at most the rate's bits, magnified by a bicubic filter; BC7 above 4 bpp.
    scaled_db: f64,
    /// BC7 at 8 bpp, with a texel for each pixel.
    bc7_db: f64,
}

/// Measures every image at every rate, beside the textures that a game would have otherwise.
pub fn run(args: &RivalsArgs) -> Result<Report, Error> {
    let all = [Rate::Color2_25, Rate::Color3, Rate::Color3_25, Rate::Color5];
    let rates = if args.rates.is_empty() {
        all.to_vec()
    } else {
        args.rates.clone()
    };
    if let Some(rate) = rates.iter().find(|r| r.content(false) != Content::Color) {
        return Err(Error::Usage(format!(
            "{} is not a rate of colour, of which the rivals are",
            rate.name()
        )));
    }
    let (rows, result) = batch::measured(&args.inputs, |name, picture| {
        rows(name, picture, &rates, args)
    })?;
    let text = if args.measurement.json {
        serde_json::to_string_pretty(&rows).expect("plain data")
    } else {
        rates.iter().map(|rate| table(rate.name(), &rows)).collect()
    };
    Ok((text, result))
}

fn rows(
    name: &str,
    picture: &Picture,
    rates: &[Rate],
    args: &RivalsArgs,
) -> Result<Vec<Row>, bevy_wavelet_tex::codec::encoder::EncodeError> {
    let source = Source::new(picture.size, picture.source());
    let original = floats(picture);
    let full_db = |format| psnr(&original, &through(&original, format));
    let bc1_db = full_db(BlockFormat::Bc1);
    let bc7_db = full_db(BlockFormat::Bc7);
    let row = |&rate: &Rate| {
        let settings = EncodeSettings {
            rate,
            color_space: if args.linear {
                ColorSpace::Linear
            } else {
                ColorSpace::Srgb
            },
            mips: false,
            effort: args.measurement.effort.into(),
            ..EncodeSettings::default()
        };
        let texture = encode(&source, &settings, &|_, _| {})?;
        let wavelet = EncodeSettings {
            formats: Formats::Wavelet,
            ..settings
        };
        let wavelet = encode(&source, &wavelet, &|_, _| {})?;
        let bytes = rate.most_bytes(source.size, false);
        let format = match rate.nominal_bits_per_pixel(false) {
            ..=4.0 => BlockFormat::Bc1,
            _ => BlockFormat::Bc7,
        };
        Ok(Row {
            image: name.into(),
            rate: rate.name(),
            chosen: texture.storage_name(),
            bpp: texture.bits_per_pixel(),
            psnr_db: psnr_db(&source, &texture),
            wavelet_db: psnr_db(&source, &wavelet),
            bc1_db,
            scaled_db: psnr(&original, &scaled(&original, format, bytes)),
            bc7_db,
        })
    };
    rates.iter().map(row).collect()
}

fn floats(picture: &Picture) -> Rgb32FImage {
    let [width, height] = picture.size;
    Rgb32FImage::from_fn(width, height, |x, y| {
        let [r, g, b, _] = picture.pixels[(y * width + x) as usize];
        Rgb([r, g, b].map(|v| f32::from(v) / 255.0))
    })
}

/// Encodes and decodes a picture. Beyond its edges, blocks repeat the outermost texels.
fn through(picture: &Rgb32FImage, format: BlockFormat) -> Rgb32FImage {
    let size = <[u32; 2]>::from(picture.dimensions());
    let blocks = match format {
        BlockFormat::Bc7 => encode_bc7(size, [1; 3], |x, y| picture.get_pixel(x, y).0),
        _ => {
            let texel = |p: &Rgb<f32>| -> Texel {
                let [r, g, b] = p.0.map(byte);
                [r, g, b, 255]
            };
            let texels: Vec<Texel> = picture.pixels().map(texel).collect();
            encode_bc1(&texels, size, BlockQuality::High)
        }
    };
    let texels = decode_blocks(format, &blocks, size);
    Rgb32FImage::from_fn(size[0], size[1], |x, y| {
        let [r, g, b, _] = texels[(y * size[0] + x) as usize];
        Rgb([r, g, b])
    })
}

/// What a texture of whole blocks and at most these bytes shows, downsampled by Lanczos and magnified by
/// Catmull-Rom where it must be smaller. Black where not a block fits.
fn scaled(picture: &Rgb32FImage, format: BlockFormat, bytes: usize) -> Rgb32FImage {
    let (width, height) = picture.dimensions();
    match PlainTexture::sizes_within([width, height], format, bytes).first() {
        None => Rgb32FImage::new(width, height),
        Some(&size) if size == PlainTexture::full_size([width, height]) => through(picture, format),
        Some(&[w, h]) => {
            let small = imageops::resize(picture, w, h, imageops::FilterType::Lanczos3);
            let small = through(&small, format);
            imageops::resize(&small, width, height, imageops::FilterType::CatmullRom)
        }
    }
}

fn byte(value: f32) -> u8 {
    (value.clamp(0.0, 1.0) * 255.0).round() as u8
}

/// PSNR in dB, with both rounded to 8 bits.
fn psnr(a: &Rgb32FImage, b: &Rgb32FImage) -> f64 {
    let values = a.as_raw().iter().zip(b.as_raw());
    let error = |(a, b): (&f32, &f32)| f64::from(byte(*a).abs_diff(byte(*b))).powi(2);
    psnr_of(values.map(error).sum::<f64>() / a.as_raw().len() as f64)
}

/// Formats the images of one rate, their means, and the least that ours are above each rival.
fn table(rate: &str, rows: &[Row]) -> String {
    let rows: BTreeMap<&str, &Row> = rows
        .iter()
        .filter(|row| row.rate == rate)
        .map(|row| (row.image.as_str(), row))
        .collect();
    let widest = rows.keys().map(|name| name.chars().count()).max();
    let width = widest.unwrap_or(0).max(rate.len()).max("least above".len());
    let columns = ["ours", "wavelet", "bc1", "scaled", "bc7"];
    let figures = |r: &Row| [r.psnr_db, r.wavelet_db, r.bc1_db, r.scaled_db, r.bc7_db];
    let line = |name: &str, figures: [f64; 5], end: &str| {
        let cells: String = figures.map(|f| format!("{f:>9.2}")).concat();
        format!("{name:width$}{cells}  {end}\n")
    };
    let heads: String = columns.map(|c| format!("{c:>9}")).concat();
    let mut text = format!("{rate:width$}{heads}  chosen\n");
    for (name, row) in &rows {
        let end = format!("{} {:.2} bpp", row.chosen, row.bpp);
        text += &line(name, figures(row), &end);
    }
    let mean: [f64; 5] = std::array::from_fn(|i| {
        let values = rows.values().map(|row| figures(row)[i]);
        let values: Vec<f64> = values.filter(|v| v.is_finite()).collect();
        values.iter().sum::<f64>() / values.len() as f64
    });
    text += &line("mean", mean, "");
    let least = std::array::from_fn(|i| {
        let above = rows.values().map(|row| row.psnr_db - figures(row)[i]);
        above.filter(|v| !v.is_nan()).fold(f64::INFINITY, f64::min)
    });
    text += &line("least above", least, "");
    text + "\n"
}

//! The baselines of the rates, and two levels of wavelets: the rows of `bench --study`.
//!
//! | rate | format |
//! | --- | --- |
//! | `bc1`, `bc7`, `bc4-gray` | the BC formats at full size |
//! | `bc1-2.25-bilinear`, `-bicubic`, `bc4-gray-2-..`, `bc7-5-..` | the BC formats of images that are downsampled by Lanczos until they take the bits of a wavelet rate, and upsampled again: textures of a lower resolution (thesis section 3.6.1) |
//! | `gray1.5` | two levels of wavelets (thesis section 3.5.4) |

mod two_levels;

use std::time::Instant;

use bevy_wavelet_tex::codec::{
    blocks::{BlockFormat, BlockQuality, decode_blocks, encode_bc1, encode_bc4, encode_bc7},
    color::ycocg_from_rgb,
    quality::psnr_of,
};
use image::{ImageBuffer, Rgb, imageops::FilterType};

use crate::{bench::Row, picture::Picture};

type Float3 = ImageBuffer<Rgb<f32>, Vec<f32>>;

/// Measures one image and returns its rows.
pub fn rows(name: &str, picture: &Picture) -> Vec<Row> {
    let row = |rate: &str, (bpp, psnr_db, encode_s): (f64, f64, f64)| Row {
        image: name.into(),
        rate: rate.into(),
        bpp,
        psnr_db,
        encode_s,
        megapixels: picture.pixels.len() as f64 / 1e6,
    };
    let color = picture_of(picture, |[r, g, b]| [r, g, b]);
    let luma = picture_of(picture, |rgb| {
        [(ycocg_from_rgb(rgb).y * 255.0).round() / 255.0; 3]
    });
    let mut rows = vec![
        row("bc1", at_full_size(&color, Rival::Bc1)),
        row("bc7", at_full_size(&color, Rival::Bc7)),
        row("bc4-gray", at_full_size(&luma, Rival::Bc4)),
    ];
    for (filter, back) in [
        ("bilinear", FilterType::Triangle),
        ("bicubic", FilterType::CatmullRom),
    ] {
        for (rate, source, rival, bpp) in [
            ("bc4-gray-1.5", &luma, Rival::Bc4, 1.5),
            ("bc4-gray-2", &luma, Rival::Bc4, 2.0),
            ("bc4-gray-3", &luma, Rival::Bc4, 3.0),
            ("bc1-2.25", &color, Rival::Bc1, 2.25),
            ("bc1-3", &color, Rival::Bc1, 3.0),
            ("bc1-3.25", &color, Rival::Bc1, 3.25),
            ("bc7-5", &color, Rival::Bc7, 5.0),
        ] {
            rows.push(row(
                &format!("{rate}-{filter}"),
                scaled(source, rival, bpp, back),
            ));
        }
    }
    rows.push(row("gray1.5", two_levels::measured(&luma)));
    rows
}

/// The format of a baseline. All take 4 bpp except BC7, which takes 8.
#[derive(Clone, Copy, PartialEq)]
enum Rival {
    Bc1,
    Bc4,
    Bc7,
}

fn picture_of(picture: &Picture, value: impl Fn([f32; 3]) -> [f32; 3]) -> Float3 {
    let [width, height] = picture.size;
    Float3::from_fn(width, height, |x, y| {
        let [r, g, b, _] = picture.pixels[(y * width + x) as usize];
        Rgb(value([r, g, b].map(|v| f32::from(v) / 255.0)))
    })
}

/// Encodes and decodes a picture. Returns the decoded picture and the bytes of its blocks.
fn through(image: &Float3, rival: Rival) -> (Float3, usize) {
    let (width, height) = image.dimensions();
    let size = [width, height];
    let byte = |v: f32| (v.clamp(0.0, 1.0) * 255.0).round() as u8;
    let (format, blocks) = match rival {
        Rival::Bc1 => {
            let texels = image.pixels().map(|p| {
                let [r, g, b] = p.0.map(byte);
                [r, g, b, 255]
            });
            let texels: Vec<_> = texels.collect();
            (
                BlockFormat::Bc1,
                encode_bc1(&texels, size, BlockQuality::High),
            )
        }
        Rival::Bc4 => {
            let values: Vec<f32> = image.pixels().map(|p| p.0[0].clamp(0.0, 1.0)).collect();
            (
                BlockFormat::Bc4,
                encode_bc4(&values, size, BlockQuality::High),
            )
        }
        Rival::Bc7 => {
            let blocks = encode_bc7(size, [1; 3], |x, y| image.get_pixel(x, y).0);
            (BlockFormat::Bc7, blocks)
        }
    };
    let texels = decode_blocks(format, &blocks, size);
    let decoded = Float3::from_fn(width, height, |x, y| {
        let [r, g, b, _] = texels[(y * width + x) as usize];
        Rgb(if rival == Rival::Bc4 {
            [r; 3]
        } else {
            [r, g, b]
        })
    });
    (decoded, blocks.len())
}

fn at_full_size(image: &Float3, rival: Rival) -> (f64, f64, f64) {
    let start = Instant::now();
    let (decoded, bytes) = through(image, rival);
    let encode_s = start.elapsed().as_secs_f64();
    (bits(bytes, image), psnr(image, &decoded), encode_s)
}

/// Encodes the picture at a lower resolution, such that the format takes `bpp`.
fn scaled(image: &Float3, rival: Rival, bpp: f64, back: FilterType) -> (f64, f64, f64) {
    let (width, height) = image.dimensions();
    let full = if rival == Rival::Bc7 { 8.0 } else { 4.0 };
    let scale = (bpp / full).sqrt();
    let [w, h] = [width, height].map(|s| ((f64::from(s) * scale).round() as u32).max(1));
    let start = Instant::now();
    let small = image::imageops::resize(image, w, h, FilterType::Lanczos3);
    let (decoded, bytes) = through(&small, rival);
    let encode_s = start.elapsed().as_secs_f64();
    let back = image::imageops::resize(&decoded, width, height, back);
    (bits(bytes, image), psnr(image, &back), encode_s)
}

fn bits(bytes: usize, image: &Float3) -> f64 {
    8.0 * bytes as f64 / (image.width() as f64 * image.height() as f64)
}

/// PSNR in dB of pictures that are rounded to 8 bits.
fn psnr(a: &Float3, b: &Float3) -> f64 {
    let byte = |v: f32| f64::from((v.clamp(0.0, 1.0) * 255.0).round());
    let pairs = a.as_raw().iter().zip(b.as_raw());
    let error: f64 = pairs.map(|(a, b)| (byte(*a) - byte(*b)).powi(2)).sum();
    psnr_of(error / a.as_raw().len() as f64)
}

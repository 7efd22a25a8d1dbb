//! Pictures of linear colours: computed, and as a display shows them.

use bevy_ewa::{
    EwaKernel, EwaSettings,
    mips::texel::srgb_from_linear,
    reference::{
        Derivatives, Texture, sample,
        scenes::{Surface, ground_truth},
    },
};
use image::RgbImage;
use rayon::prelude::*;

/// Linear colours of a square picture, row after row.
pub type Pixels = Vec<[f64; 3]>;

/// What a picture should look like, by `rate` times `rate` points a pixel.
pub fn true_picture(texture: &Texture, surface: &Surface, size: u32, rate: u32) -> Pixels {
    rows(size, |y| {
        let texture = texture.clone();
        let pixel =
            move |x| ground_truth(&texture, surface, size, [x, y], EwaKernel::default(), rate);
        (0..size).map(pixel).map(rgb).collect()
    })
}

/// The picture by the reference in plain Rust, and its fetches a pixel.
pub fn computed_picture(
    texture: &Texture,
    coordinates: &[([f64; 2], Derivatives)],
    size: u32,
    settings: &EwaSettings,
    frame: u32,
) -> (Pixels, f64) {
    let sampled = rows(size, |y| {
        let texture = texture.clone();
        let row = &coordinates[(y * size) as usize..][..size as usize];
        row.iter()
            .map(|(uv, d)| sample(&texture, *uv, *d, settings, frame))
            .collect()
    });
    let fetches: u64 = sampled.iter().map(|s| u64::from(s.fetches)).sum();
    let pixels = sampled.iter().map(|s| rgb(s.color)).collect();
    (pixels, fetches as f64 / f64::from(size * size))
}

fn rows<T: Send>(size: u32, row: impl Fn(u32) -> Vec<T> + Sync + Send) -> Vec<T> {
    (0..size).into_par_iter().flat_map_iter(row).collect()
}

fn rgb([r, g, b, _]: [f64; 4]) -> [f64; 3] {
    [r, g, b]
}

/// The mean of pictures of the same size.
pub fn mean(pictures: &[Pixels]) -> Pixels {
    let Some(first) = pictures.first() else {
        return Pixels::new();
    };
    let count = pictures.len() as f64;
    (0..first.len())
        .map(|i| [0, 1, 2].map(|c| pictures.iter().map(|p| p[i][c]).sum::<f64>() / count))
        .collect()
}

pub fn display(pixels: &Pixels, size: u32) -> RgbImage {
    RgbImage::from_fn(size, size, |x, y| {
        image::Rgb(pixels[(y * size + x) as usize].map(|c| {
            let value = srgb_from_linear((c as f32).clamp(0.0, 1.0));
            (value * 255.0).round() as u8
        }))
    })
}

/// Mean squared error of linear values, in squares of 8-bit units; finer than that of bytes.
pub fn linear_mse(a: &Pixels, b: &Pixels) -> f64 {
    let pairs = a.iter().flatten().zip(b.iter().flatten());
    let sum: f64 = pairs.map(|(a, b)| ((a - b) * 255.0).powi(2)).sum();
    sum / (3 * a.len().max(1)) as f64
}

//! The pixels of every mip against the original, reduced to its size.
#![cfg(feature = "encode")]

use bevy_wavelet_tex::codec::{
    color::{linear_from_srgb, srgb_from_linear},
    decoder::decode,
    encoder::encode,
    image::WaveletImage,
    layout::{level_count, mip_size},
    quality::psnr_of,
    settings::{EncodeSettings, Formats},
    source::{Pixels, Source},
};

type Picture = fn(u32, u32) -> [u8; 3];

/// Slow waves: the large levels have hardly any detail, the small ones hardly anything else.
fn waves(x: u32, y: u32) -> [u8; 3] {
    let (x, y) = (x as f32, y as f32);
    let wave = |v: f32| (127.5 + 127.0 * v.sin()) as u8;
    [
        wave(x / 21.0 + (y / 37.0).sin()),
        wave(y / 25.0 + x / 60.0),
        wave((x + y) / 29.0),
    ]
}

/// Coarse squares with noise on them: the large levels have more detail than the small ones.
fn squares(x: u32, y: u32) -> [u8; 3] {
    let hash = |x: u32, y: u32| (x * 7919 + y * 104_729 + x * y * 31) % 251;
    let ground = hash(x / 48, y / 48);
    let noise = hash(x, y) / 6;
    [0, 40, 90].map(|c| ((ground * (c + 160) / 250).min(210) + noise) as u8)
}

/// The mean over the area of each pixel of a smaller size, in linear light.
fn reduced(picture: Picture, size: [u32; 2], to: [u32; 2]) -> Vec<[f64; 3]> {
    let covered = |i: u32, axis: usize| {
        let scale = f64::from(size[axis]) / f64::from(to[axis]);
        let (start, end) = (f64::from(i) * scale, f64::from(i + 1) * scale);
        let samples = start as u32..(end.ceil() as u32).min(size[axis]);
        samples.map(move |s| {
            (
                s,
                (end.min(f64::from(s) + 1.0) - start.max(f64::from(s))) / scale,
            )
        })
    };
    let linear: Vec<f64> = (0..256)
        .map(|v| f64::from(linear_from_srgb(v as f32 / 255.0)))
        .collect();
    let pixels = (0..to[1]).flat_map(|y| (0..to[0]).map(move |x| (x, y)));
    pixels
        .map(|(x, y)| {
            let mut sum = [0.0; 3];
            for (sy, v) in covered(y, 1) {
                for (sx, u) in covered(x, 0) {
                    let pixel = picture(sx, sy);
                    for (sum, value) in sum.iter_mut().zip(pixel) {
                        *sum += u * v * linear[usize::from(value)];
                    }
                }
            }
            sum.map(|v| 255.0 * f64::from(srgb_from_linear(v as f32)))
        })
        .collect()
}

fn pixels_of(picture: Picture, size: [u32; 2]) -> Vec<[u8; 3]> {
    let positions = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y)));
    positions.map(|(x, y)| picture(x, y)).collect()
}

/// PSNR of a level in dB.
fn level_db(image: &WaveletImage, level: u32, expected: &[[f64; 3]]) -> f64 {
    let decoded = decode(image, level).pixels;
    let of_pixel = |(actual, expected): (&[f32; 3], &[f64; 3])| -> f64 {
        let channels = actual.iter().zip(expected);
        channels
            .map(|(g, w)| (255.0 * f64::from(*g) - w).powi(2))
            .sum()
    };
    let sum: f64 = decoded.iter().zip(expected).map(of_pixel).sum();
    psnr_of(sum / (3 * expected.len()) as f64)
}

/// The error of all levels, each of which has half the weight of the one before.
fn chain_error(image: &WaveletImage, expected: &[Vec<[f64; 3]>]) -> f64 {
    let weight = |level: u32| 0.5f64.powi(level as i32);
    let levels = 0..image.levels;
    let error = |level: u32| {
        let db = level_db(image, level, &expected[level as usize]);
        weight(level) * 10f64.powf(-db / 10.0)
    };
    levels.clone().map(error).sum::<f64>() / levels.map(weight).sum::<f64>()
}

/// The levels of a wavelet share their parameters, and none pays for that with much more than what it has as an image of
/// its own. Of wavelets and plain textures, that is kept whose levels together have the least error.
#[test]
fn all_levels_decide_and_none_is_neglected() {
    for (name, picture) in [("waves", waves as Picture), ("squares", squares)] {
        for size in [[1000, 1000], [1920, 1080], [1, 6]] {
            let pixels = pixels_of(picture, size);
            let source = Source::new(size, Pixels::Rgb8(&pixels));
            let expected: Vec<_> = (0..level_count(size))
                .map(|level| reduced(picture, size, mip_size(size, level)))
                .collect();
            let encoded = |formats| {
                let settings = EncodeSettings {
                    formats,
                    ..EncodeSettings::default()
                };
                let image = encode(&source, &settings, &|_, _| {}).expect("a good image");
                let last = image.levels - 1;
                // A smaller texture can end a level before its image.
                let texels = image.plain().map(|plain| plain.level_size(last));
                assert!(mip_size(size, last) == [1, 1] || texels == Some([1, 1]));
                image
            };
            let wavelet = encoded(Formats::Wavelet);
            for (level, expected) in (0..).zip(&expected) {
                let rounded = expected.iter().map(|pixel| pixel.map(|v| v.round() as u8));
                let rounded: Vec<[u8; 3]> = rounded.collect();
                let settings = EncodeSettings {
                    mips: false,
                    formats: Formats::Wavelet,
                    ..EncodeSettings::default()
                };
                let own = Source::new(mip_size(size, level), Pixels::Rgb8(&rounded));
                let own = encode(&own, &settings, &|_, _| {}).expect("a good image");
                let (own, found) = (
                    level_db(&own, 0, expected),
                    level_db(&wavelet, level, expected),
                );
                println!("{name} {size:?} {level}: {found:.2} dB, {own:.2} dB on its own");
                let (most, less) = if expected.len() < 1024 {
                    (30.0, 3.0)
                } else {
                    (36.0, 2.0)
                };
                assert!(found >= own.min(most) - less, "{found} {own}");
            }
            let of_wavelet = chain_error(&wavelet, &expected);
            let [any, of_plain] = [Formats::Any, Formats::Plain]
                .map(|formats| chain_error(&encoded(formats), &expected));
            println!("{name} {size:?}: {any:.2e} of {of_wavelet:.2e}, {of_plain:.2e}");
            assert!(any <= 1.01 * of_wavelet.min(of_plain));
        }
    }
}

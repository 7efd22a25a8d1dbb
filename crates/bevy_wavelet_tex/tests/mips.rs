//! The pixels of every mip against the original, reduced to its size.
#![cfg(feature = "encode")]

use bevy_wavelet_tex::codec::{
    color::{linear_from_srgb, srgb_from_linear},
    decoder::decode,
    encoder::encode,
    layout::mip_size,
    settings::{Effort, EncodeSettings, Formats},
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
    let pixels = (0..to[1]).flat_map(|y| (0..to[0]).map(move |x| (x, y)));
    pixels
        .map(|(x, y)| {
            let mut sum = [0.0; 3];
            for (sy, v) in covered(y, 1) {
                for (sx, u) in covered(x, 0) {
                    let pixel = picture(sx, sy);
                    for (sum, value) in sum.iter_mut().zip(pixel) {
                        *sum += u * v * f64::from(linear_from_srgb(f32::from(value) / 255.0));
                    }
                }
            }
            sum.map(|v| 255.0 * f64::from(srgb_from_linear(v as f32)))
        })
        .collect()
}

/// The mean error of a channel in each level, in 8-bit units.
fn errors(picture: Picture, size: [u32; 2], settings: &EncodeSettings) -> Vec<f64> {
    let positions = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y)));
    let pixels: Vec<[u8; 3]> = positions.map(|(x, y)| picture(x, y)).collect();
    let source = Source::new(size, Pixels::Rgb8(&pixels));
    let image = encode(&source, settings, &|_, _| {}).expect("a good image");
    assert_eq!(mip_size(size, image.levels - 1), [1, 1]);
    let of_level = |level: u32| {
        let decoded = decode(&image, level);
        let wanted = reduced(picture, size, decoded.size);
        let of_pixel = |(got, wanted): (&[f32; 3], &[f64; 3])| -> f64 {
            let channels = got.iter().zip(wanted);
            channels
                .map(|(g, w)| (255.0 * f64::from(*g) - w).abs())
                .sum()
        };
        let sum: f64 = decoded.pixels.iter().zip(&wanted).map(of_pixel).sum();
        sum / (3 * wanted.len()) as f64
    };
    (0..image.levels).map(of_level).collect()
}

#[test]
fn every_mip_is_near_the_reduced_original() {
    for (name, picture) in [("waves", waves as Picture), ("squares", squares)] {
        for size in [[512, 512], [500, 300]] {
            for effort in [Effort::Fast, Effort::Default] {
                for formats in [Formats::Any, Formats::Wavelet] {
                    let settings = EncodeSettings {
                        effort,
                        formats,
                        ..EncodeSettings::default()
                    };
                    let errors = errors(picture, size, &settings);
                    println!("{name} {size:?} {effort:?} {formats:?}: {errors:.1?}");
                    for (level, error) in errors.iter().enumerate() {
                        assert!(
                            *error < 7.0,
                            "{name} {size:?} {effort:?}, level {level}: {error}"
                        );
                    }
                }
            }
        }
    }
}

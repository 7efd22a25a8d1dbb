//! The choice between wavelets and plain textures, and the pixels of every mip against the original, reduced to its size.
#![cfg(feature = "encode")]

use bevy_wavelet_tex::{
    codec::{
        blocks::{BlockFormat, BlockQuality, decode_blocks, encode_bc1, encode_bc7},
        color::{linear_from_srgb, srgb_from_linear},
        decoder::{decode, normal_from_xy},
        encoder::encode,
        image::{ColorSpace, Content, WaveletImage},
        layout::{level_count, mip_size},
        plain::PlainTexture,
        plane::Plane,
        quality::{psnr_db, psnr_of},
        rate::Rate,
        settings::{Effort, EncodeSettings, Formats, Method},
        source::{Pixels, Source},
    },
    file,
};
use image::imageops;

type Picture = fn(u32, u32) -> [u8; 4];

/// Stripes and dots of three saturated colours of the same luma.
fn painted(x: u32, y: u32) -> [u8; 4] {
    let [a, b, c] = [[229, 51, 127, 255], [26, 153, 127, 90], [127, 51, 229, 255]];
    match ((x / 7 + y / 11) % 3, (x + 2 * y) % 29) {
        (_, 0) => c,
        (0, _) => a,
        (1, _) => b,
        _ => c,
    }
}

/// Slopes, which a wavelet predicts.
fn smooth(x: u32, y: u32) -> [u8; 4] {
    let wave = |v: f32| (127.5 + 120.0 * v.sin()) as u8;
    let (x, y) = (x as f32, y as f32);
    let luma = wave(x / 17.0 + y / 23.0);
    [luma, luma / 2 + 60, wave(x / 90.0), wave(y / 40.0)]
}

/// Channels that have nothing in common.
fn packed(x: u32, y: u32) -> [u8; 4] {
    let hash = (x * 7919 + y * 104_729) % 251;
    let edge = if (x / 13 + y / 9).is_multiple_of(2) {
        0
    } else {
        255
    };
    [(y % 256) as u8, (100 + hash / 3) as u8, edge, 255]
}

const PICTURES: [(&str, Picture); 3] =
    [("painted", painted), ("smooth", smooth), ("packed", packed)];

fn encoded(picture: Picture, size: [u32; 2], settings: &EncodeSettings) -> (WaveletImage, f64) {
    let pixels: Vec<[u8; 4]> = Plane::positions(size).map(|(x, y)| picture(x, y)).collect();
    let source = Source::new(size, Pixels::Rgba8(&pixels));
    let image = encode(&source, settings, &|_, _| {}).expect("a good image");
    assert_eq!(
        file::read(&file::write(&image)).expect("a good file"),
        image
    );
    let psnr = psnr_db(&source, &image);
    (image, psnr)
}

/// No rate is worse than the best of each kind, and none takes more bits than it may.
fn check(size: [u32; 2], rates: &[Rate], effort: Effort, doubt_db: f64) {
    let mut kinds = [0; 2];
    for (name, picture) in PICTURES {
        for &rate in rates {
            for alpha in [false, true] {
                let with = |formats| {
                    let settings = EncodeSettings {
                        rate,
                        alpha,
                        effort,
                        formats,
                        color_space: ColorSpace::Srgb,
                        mips: false,
                        ..EncodeSettings::default()
                    };
                    encoded(picture, size, &settings)
                };
                let (image, any) = with(Formats::Any);
                let (_, wavelet) = with(Formats::Wavelet);
                let (plain_image, plain) = with(Formats::Plain);
                println!(
                    "{name} {} {alpha}: {any:.2} {wavelet:.2} {plain:.2}",
                    rate.name()
                );
                assert!(any >= wavelet.max(plain) - doubt_db, "{name} {rate:?}");
                assert!(plain_image.plain().is_some());
                assert!(plain_image.gpu_bytes() <= rate.most_bytes(size, alpha));
                kinds[usize::from(image.plain().is_some())] += 1;
            }
        }
    }
    assert!(kinds.iter().all(|kind| *kind > 0), "{kinds:?}");
}

#[test]
fn no_rate_is_worse_than_the_best_of_each_kind() {
    check([92, 60], &Rate::ALL, Effort::Default, 0.0);
}

#[test]
fn the_error_of_large_images_is_estimated_well() {
    check(
        [64, 256],
        &[Rate::Color2_25, Rate::Gray2],
        Effort::Default,
        0.05,
    );
}

#[test]
fn painted_signs_are_best_in_bc1_and_a_wanted_quality_finds_it() {
    let settings = EncodeSettings {
        min_psnr_db: Some(35.0),
        ..EncodeSettings::default()
    };
    let (image, psnr) = encoded(painted, [128, 128], &settings);
    let plain = image.plain().expect("plain");
    assert!(psnr >= 35.0, "{psnr}");
    assert_eq!(image.levels, 8);
    println!("{:?} {:?} {psnr:.2} dB", plain.format, plain.size);
    let all = EncodeSettings {
        min_psnr_db: Some(99.0),
        ..settings
    };
    let (image, _) = encoded(painted, [128, 128], &all);
    assert_eq!(
        image.plain().map(|plain| plain.format),
        Some(BlockFormat::Bc7)
    );
}

#[test]
fn the_thesis_stays_a_wavelet() {
    for formats in [Formats::Any, Formats::Plain] {
        let settings = EncodeSettings {
            formats,
            method: Method::Thesis,
            ..EncodeSettings::default()
        };
        assert!(encoded(painted, [64, 64], &settings).0.plain().is_none());
    }
}

/// A plain texture at full size has the pixels of an image and more, which decoders leave out.
#[test]
fn pixels_of_any_size_are_texels_of_a_padded_texture() {
    for size in [[1, 1], [3, 5], [9, 4], [17, 33], [30, 62], [93, 61]] {
        for (rate, alpha) in [
            (Rate::Gray4, false),
            (Rate::Color8, false),
            (Rate::Color8, true),
            (Rate::Normal8, false),
        ] {
            let settings = EncodeSettings {
                rate,
                alpha,
                formats: Formats::Plain,
                color_space: ColorSpace::Srgb,
                ..EncodeSettings::default()
            };
            let (image, _) = encoded(packed, size, &settings);
            let plain = image.plain().expect("plain");
            assert!(plain.is_padded(size) && !plain.is_scaled(size));
            assert_eq!(image.levels, 32 - size[0].max(size[1]).leading_zeros());
            for level in 0..image.levels {
                let [width, height] = plain.level_size(level);
                let blocks = plain.level_blocks(level);
                let texels = decode_blocks(plain.format, blocks, [width, height]);
                let decoded = decode(&image, level);
                let [across, down] = decoded.size;
                assert!(across <= width && down <= height);
                for i in 0..across * down {
                    let texel = texels[(i / across * width + i % across) as usize];
                    let pixel = decoded.pixels[i as usize];
                    let expected = match rate {
                        Rate::Gray4 => [texel[0]; 3],
                        Rate::Normal8 => normal_from_xy([0, 1].map(|c| 2.0 * texel[c] - 1.0)),
                        _ => [texel[0], texel[1], texel[2]],
                    };
                    assert_eq!(pixel, expected, "{rate:?} {size:?} {level}");
                    if let Some(alpha) = &decoded.alpha {
                        assert_eq!(alpha[i as usize], texel[3]);
                    }
                }
            }
        }
    }
}

/// PSNR in dB of a texture of whole blocks that has at most these bytes, downsampled by Lanczos and magnified
/// by Catmull-Rom where it must be smaller.
fn rival_db(picture: Picture, size: [u32; 2], format: BlockFormat, bytes: usize) -> f64 {
    let [width, height] = size;
    let original = image::Rgb32FImage::from_fn(width, height, |x, y| {
        let [r, g, b, _] = picture(x, y).map(|v| f32::from(v) / 255.0);
        image::Rgb([r, g, b])
    });
    let through = |picture: &image::Rgb32FImage| {
        let size = picture.dimensions().into();
        let byte = |v: f32| (v.clamp(0.0, 1.0) * 255.0).round() as u8;
        let texels = picture.pixels().map(|p| {
            let [r, g, b] = p.0.map(byte);
            [r, g, b, 255]
        });
        let blocks = match format {
            BlockFormat::Bc1 => encode_bc1(&texels.collect::<Vec<_>>(), size, BlockQuality::High),
            _ => encode_bc7(size, [1; 3], |x, y| picture.get_pixel(x, y).0),
        };
        let texels = decode_blocks(format, &blocks, size);
        image::Rgb32FImage::from_fn(size[0], size[1], |x, y| {
            let [r, g, b, _] = texels[(y * size[0] + x) as usize];
            image::Rgb([r, g, b])
        })
    };
    let sizes = PlainTexture::sizes_within(size, format, bytes);
    let shown = match sizes.first() {
        None => return 0.0,
        Some(&texels) if texels == PlainTexture::full_size(size) => through(&original),
        Some(&[w, h]) => {
            let small = imageops::resize(&original, w, h, imageops::FilterType::Lanczos3);
            imageops::resize(
                &through(&small),
                width,
                height,
                imageops::FilterType::CatmullRom,
            )
        }
    };
    exact_db(picture, size, shown.pixels().map(|pixel| pixel.0))
}

/// PSNR in dB of decoded pixels that are not rounded to 8 bits: at a tie of two blocks rounding would decide.
fn exact_db(picture: Picture, size: [u32; 2], shown: impl Iterator<Item = [f32; 3]>) -> f64 {
    let error = |((x, y), shown): ((u32, u32), [f32; 3])| -> f64 {
        let [r, g, b, _] = picture(x, y).map(f64::from);
        let pairs = [r, g, b].into_iter().zip(shown);
        pairs
            .map(|(expected, shown)| (expected - 255.0 * f64::from(shown.clamp(0.0, 1.0))).powi(2))
            .sum()
    };
    let sum: f64 = Plane::positions(size).zip(shown).map(error).sum();
    psnr_of(sum / f64::from(3 * size[0] * size[1]))
}

#[test]
#[ignore = "long: 480 encodings"]
fn no_size_is_worse_than_a_texture_of_the_same_bytes() {
    let small = (1..=9).flat_map(|w| [[w, 1], [w, 6], [w, 9]]);
    let larger = [[17, 17], [33, 30], [30, 33], [61, 93], [250, 90]];
    for size in small.chain(larger) {
        for (name, picture) in PICTURES {
            for rate in Rate::of(Content::Color) {
                let settings = EncodeSettings {
                    rate,
                    color_space: ColorSpace::Srgb,
                    mips: false,
                    ..EncodeSettings::default()
                };
                let (image, _) = encoded(picture, size, &settings);
                let psnr = exact_db(picture, size, decode(&image, 0).pixels.into_iter());
                let bytes = rate.most_bytes(size, false);
                assert!(image.gpu_bytes() <= bytes);
                let rivals = PlainTexture::formats(Content::Color).iter();
                let rival = rivals.map(|format| rival_db(picture, size, *format, bytes));
                let rival = rival.fold(0.0, f64::max);
                // Above 45 dB, how values are rounded to 8 bits decides.
                assert!(
                    psnr >= rival.min(45.0),
                    "{size:?} {name} {rate:?}: {psnr} {rival}, {}",
                    image.storage_name()
                );
            }
        }
    }
}

type Opaque = fn(u32, u32) -> [u8; 3];

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
fn reduced(picture: Opaque, size: [u32; 2], to: [u32; 2]) -> Vec<[f64; 3]> {
    let covered = |i: u32, axis: usize| {
        let scale = f64::from(size[axis]) / f64::from(to[axis]);
        let (start, end) = (f64::from(i) * scale, f64::from(i + 1) * scale);
        let samples = start as u32..(end.ceil() as u32).min(size[axis]);
        samples.map(move |s| {
            let [first, last] = [start.max(f64::from(s)), end.min(f64::from(s) + 1.0)];
            (s, (last - first) / scale)
        })
    };
    let linear: Vec<f64> = (0..256)
        .map(|v| f64::from(linear_from_srgb(v as f32 / 255.0)))
        .collect();
    Plane::positions(to)
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
#[ignore = "long: large images"]
fn all_levels_decide_and_none_is_neglected() {
    for (name, picture) in [("waves", waves as Opaque), ("squares", squares)] {
        for size in [[1000, 1000], [1920, 1080], [1, 6]] {
            let pixels: Vec<_> = Plane::positions(size).map(|(x, y)| picture(x, y)).collect();
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
                let own = level_db(&own, 0, expected);
                let found = level_db(&wavelet, level, expected);
                println!("{name} {size:?} {level}: {found:.2} dB, {own:.2} dB on its own");
                let (most, less) = match expected.len() {
                    ..1024 => (30.0, 3.0),
                    _ => (36.0, 2.0),
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

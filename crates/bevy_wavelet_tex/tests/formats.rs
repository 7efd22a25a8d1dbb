//! The choice between wavelets and plain textures.
#![cfg(feature = "encode")]

use bevy_wavelet_tex::{
    codec::{
        blocks::BlockFormat,
        encoder::encode,
        image::{ColorSpace, WaveletImage},
        quality::psnr_db,
        rate::Rate,
        settings::{Effort, EncodeSettings, Formats, Method},
        source::{Pixels, Source},
    },
    file,
};

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
    let positions = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y)));
    let pixels: Vec<[u8; 4]> = positions.map(|(x, y)| picture(x, y)).collect();
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
                assert!(plain_image.plain.is_some());
                let most = rate.nominal_bits_per_pixel(alpha);
                assert!(plain_image.bits_per_pixel() <= most);
                kinds[usize::from(image.plain.is_some())] += 1;
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
    let plain = image.plain.expect("plain");
    assert!(psnr >= 35.0, "{psnr}");
    assert_eq!(image.levels, 8);
    println!("{:?} {:?} {psnr:.2} dB", plain.format, plain.size);
    let all = EncodeSettings {
        min_psnr_db: Some(99.0),
        ..settings
    };
    let (image, _) = encoded(painted, [128, 128], &all);
    assert_eq!(
        image.plain.map(|plain| plain.format),
        Some(BlockFormat::Bc7)
    );
}

#[test]
fn images_without_a_block_and_the_thesis_stay_wavelets() {
    for formats in [Formats::Any, Formats::Plain] {
        let settings = EncodeSettings {
            formats,
            ..EncodeSettings::default()
        };
        assert!(encoded(painted, [3, 40], &settings).0.plain.is_none());
        let thesis = EncodeSettings {
            method: Method::Thesis,
            ..settings
        };
        assert!(encoded(painted, [64, 64], &thesis).0.plain.is_none());
    }
}

//! Round trips of images of all sizes and extreme contents through encoder, file and decoder.

#![cfg(feature = "encode")]

use bevy_wavelet_tex::{
    codec::{
        decoder::decode,
        encoder::{EncodeError, encode, encode_rgb8},
        haar::Transform,
        image::{ColorSpace, Content, Payload, WaveletImage},
        layout,
        quality::psnr_db,
        rate::Rate,
        settings::{Effort, EncodeSettings, Formats, Method},
        source::{Pixels, Source},
    },
    file,
};

/// Encodes and writes an image, reads it, and decodes every level.
fn round_trip(source: &Source<'_>, settings: &EncodeSettings) -> WaveletImage {
    let image = encode(source, settings, &|_, _| {}).expect("a good image");
    let back = file::read(&file::write(&image)).expect("a good file");
    assert_eq!(back, image);
    for level in 0..back.levels {
        let decoded = decode(&back, level);
        assert_eq!(decoded.size, layout::mip_size(source.size, level));
        let count = decoded.size[0] as usize * decoded.size[1] as usize;
        assert_eq!(decoded.pixels.len(), count);
        assert!(decoded.pixels.iter().flatten().all(|v| v.is_finite()));
    }
    back
}

fn settings(rate: Rate, effort: Effort) -> EncodeSettings {
    EncodeSettings {
        rate,
        effort,
        ..EncodeSettings::default()
    }
}

fn smooth(size: [u32; 2]) -> Vec<[u8; 4]> {
    let wave = |x: u32, y: u32, f: f32| 127.0 + 90.0 * (x as f32 * f + y as f32 * 0.03).sin();
    (0..size[0] * size[1])
        .map(|i| (i % size[0], i / size[0]))
        .map(|(x, y)| [0.04, 0.05, 0.06, 0.02].map(|f| wave(x, y, f) as u8))
        .collect()
}

#[test]
fn every_size_up_to_33_squared_comes_back() {
    for width in 1..=33 {
        for height in 1..=33 {
            let pixels = smooth([width, height]);
            let source = Source::new([width, height], Pixels::Rgba8(&pixels));
            // Each size is tested at one rate, each rate at many sizes.
            let rate = Rate::ALL[(width * 5 + height) as usize % 6];
            let settings = EncodeSettings {
                alpha: (width + height) % 3 == 0,
                ..settings(rate, Effort::Fast)
            };
            let image = round_trip(&source, &settings);
            let psnr = psnr_db(&source, &image);
            assert!(psnr > 34.0, "{} {width} x {height}: {psnr} dB", rate.name());
        }
    }
}

#[test]
fn odd_large_sizes_and_strips_come_back() {
    for size in [[1, 1025], [2047, 3], [333, 517], [4096, 1]] {
        let pixels = smooth(size);
        let source = Source::new(size, Pixels::Rgba8(&pixels));
        for rate in [Rate::Gray2, Rate::Color2_25, Rate::Color5] {
            let image = round_trip(&source, &settings(rate, Effort::Default));
            let psnr = psnr_db(&source, &image);
            assert!(psnr > 36.0, "{} {size:?}: {psnr} dB", rate.name());
        }
    }
}

#[test]
fn one_colour_comes_back_at_every_rate_and_level() {
    for color in [[0, 0, 0, 0], [255; 4], [13, 200, 77, 128], [255, 0, 0, 255]] {
        let pixels = vec![color; 24 * 20];
        let source = Source::new([24, 20], Pixels::Rgba8(&pixels));
        for rate in Rate::ALL {
            let content = rate.content(true);
            if content == Content::Normal {
                continue;
            }
            let settings = EncodeSettings {
                alpha: true,
                ..settings(rate, Effort::Default)
            };
            let image = round_trip(&source, &settings);
            for level in 0..image.levels {
                for pixel in decode(&image, level).to_rgba8(content) {
                    let channels = if content == Content::Gray { 0 } else { 4 };
                    // Fully transparent pixels have no colour after the first level.
                    let first = if color[3] == 0 && level > 0 { 3 } else { 0 };
                    for c in first..channels {
                        let off = pixel[c].abs_diff(color[c]);
                        assert!(off <= 2, "{} level {level}: {pixel:?}", rate.name());
                    }
                }
            }
        }
    }
}

#[test]
fn extremes_survive() {
    let size = [64, 48];
    let noise = |i: u32| {
        let z = u64::from(i).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let z = (z ^ (z >> 31)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z >> 40).to_le_bytes()
    };
    let checker = |i: u32| [255 * ((i % 64 + i / 64 + 1) % 2) as u8; 8];
    let dot = |i: u32| [if i == 1000 { 255 } else { 0 }; 8];
    let stripes = |i: u32| [255 * ((i + 1) % 2) as u8, 0, 255, 0, 0, 0, 0, 0];
    let pictures: [(&str, &dyn Fn(u32) -> [u8; 8]); 4] = [
        ("noise", &noise),
        ("checker", &checker),
        ("dot", &dot),
        ("stripes", &stripes),
    ];
    for (name, value) in pictures {
        let pixels: Vec<[u8; 3]> = (0..size[0] * size[1])
            .map(value)
            .map(|v| [v[0], v[1], v[2]])
            .collect();
        let source = Source::new(size, Pixels::Rgb8(&pixels));
        for rate in Rate::ALL {
            for method in [Method::Best, Method::Thesis] {
                let settings = EncodeSettings {
                    method,
                    ..settings(rate, Effort::Default)
                };
                let image = round_trip(&source, &settings);
                let psnr = psnr_db(&source, &image);
                println!("{name} {} {method:?}: {psnr:.1} dB", rate.name());
                // Noise cannot be stored at these rates, but the error must not exceed that of no
                // detail.
                assert!(psnr > 4.5, "{name} {}: {psnr} dB", rate.name());
            }
        }
    }
    // A checkerboard has all of its energy in HH, which is as strong as possible.
    let pixels: Vec<[u8; 3]> = (0..64 * 48).map(checker).map(|v| [v[0]; 3]).collect();
    let source = Source::new(size, Pixels::Rgb8(&pixels));
    let image = round_trip(&source, &settings(Rate::Gray2, Effort::Default));
    assert!(psnr_db(&source, &image) > 40.0);
}

#[test]
fn a_pixel_alone_and_small_w_come_back() {
    let source = Source::new([1, 1], Pixels::Gray8(&[77]));
    let image = round_trip(&source, &settings(Rate::Gray2, Effort::Best));
    assert!(decode(&image, 0).to_rgba8(Content::Gray)[0][0].abs_diff(77) <= 1);

    let pixels = smooth([32, 32]);
    let source = Source::new([32, 32], Pixels::Rgba8(&pixels));
    let thesis = EncodeSettings {
        method: Method::Thesis,
        ..settings(Rate::Gray2, Effort::Fast)
    };
    for w in [0.01, 1.0] {
        let mut image = encode(&source, &thesis, &|_, _| {}).expect("a good image");
        let Payload::Wavelet(planes) = &mut image.payload else {
            panic!("not a wavelet")
        };
        planes.luma.codings[0].transform = Transform::PartiallyInvertedHaar { w };
        let back = file::read(&file::write(&image)).expect("a good file");
        let decoded = decode(&back, 0);
        let mut values = decoded.pixels.iter().flatten();
        assert!(values.all(|v| (0.0..=1.0).contains(v)));
    }
}

#[test]
fn sixteen_bits_gray_and_rgba_are_the_same_picture() {
    let size = [40, 24];
    let rgba = smooth(size);
    let opaque: Vec<[u8; 4]> = rgba.iter().map(|p| [p[0], p[0], p[0], 255]).collect();
    let gray: Vec<u8> = rgba.iter().map(|p| p[0]).collect();
    let gray_words: Vec<u16> = gray.iter().map(|v| u16::from(*v) * 257).collect();
    let words = opaque.iter().map(|p| p.map(|v| u16::from(v) * 257));
    let words: Vec<[u16; 4]> = words.collect();
    let rgb: Vec<[u8; 3]> = opaque.iter().map(|p| [p[0], p[1], p[2]]).collect();
    let settings = settings(Rate::Gray2, Effort::Default);
    let all = [
        Pixels::Gray8(&gray),
        Pixels::Gray16(&gray_words),
        Pixels::Rgb8(&rgb),
        Pixels::Rgba8(&opaque),
        Pixels::Rgba16(&words),
    ];
    let pictures = all.map(|pixels| {
        let image = round_trip(&Source::new(size, pixels), &settings);
        decode(&image, 0).to_rgba8(Content::Gray)
    });
    for other in &pictures[1..] {
        let pairs = pictures[0].iter().zip(other);
        // 16-bit values differ only in the last bits of a float.
        assert!(pairs.into_iter().all(|(a, b)| a[0].abs_diff(b[0]) <= 1));
    }
}

#[test]
fn given_mips_are_kept_as_they_are() {
    let first = vec![[120u8; 3]; 32 * 32];
    let second = vec![[10u8; 3]; 16 * 16];
    let third = vec![[240u8; 3]; 8 * 8];
    let source = Source {
        size: [32, 32],
        levels: [&first, &second, &third].map(|l| Pixels::Rgb8(l)).into(),
    };
    for rate in [Rate::Gray2, Rate::Color3, Rate::Color5] {
        let image = round_trip(&source, &settings(rate, Effort::Default));
        assert_eq!(image.levels, 3);
        for (level, expected) in [(0, 120), (1, 10), (2, 240u8)] {
            let decoded = decode(&image, level).to_rgba8(image.content);
            let near = |p: &[u8; 4]| p[..3].iter().all(|v| v.abs_diff(expected) <= 2);
            assert!(decoded.iter().all(near), "{} level {level}", rate.name());
        }
    }
}

#[test]
fn the_prediction_pays_and_a_wanted_quality_is_reached() {
    // The picture has slopes of all strengths in all directions, as photographs have.
    let pixels: Vec<[u8; 4]> = (0..128 * 96)
        .map(|i| ((i % 128) as f32, (i / 128) as f32))
        .map(|(x, y)| {
            let v = (x * 0.11 + (y * 0.07).sin() * 3.0).sin() + (y * 0.3 + x * x * 0.003).sin();
            [127.0 + 55.0 * v, 120.0 + 40.0 * v, 90.0 - 30.0 * v, 255.0].map(|v| v as u8)
        })
        .collect();
    let source = Source::new([128, 96], Pixels::Rgba8(&pixels));
    let quality = |settings: EncodeSettings| {
        let image = encode(&source, &settings, &|_, _| {}).expect("a good image");
        (psnr_db(&source, &image), image.bits_per_pixel())
    };
    let with = EncodeSettings {
        formats: Formats::Wavelet,
        ..settings(Rate::Gray2, Effort::Default)
    };
    let without = EncodeSettings {
        method: Method::OneFetch,
        ..with
    };
    let gain = quality(with).0 - quality(without).0;
    println!("prediction: {gain:.2} dB");
    assert!(gain > 0.3, "{gain} dB");
    let mut last = 0.0;
    for min_psnr in [20.0, 30.0, 35.0] {
        let auto = EncodeSettings {
            min_psnr_db: Some(min_psnr),
            ..settings(Rate::Color3, Effort::Default)
        };
        let (psnr, bits) = quality(auto);
        let is_enough = psnr >= min_psnr && bits >= last;
        assert!(is_enough, "{min_psnr}: {psnr} dB at {bits}");
        last = bits;
    }
}

#[test]
fn what_is_no_image_is_named() {
    let settings = EncodeSettings::default();
    let error = encode_rgb8(&[], [0, 5], &settings).expect_err("no size");
    assert!(matches!(error, EncodeError::Size([0, 5])));
    let error = encode_rgb8(&[[0; 3]; 5], [2, 2], &settings).expect_err("too many");
    let error = error.to_string();
    assert!(error.contains("should have 4 pixels, it has 5"), "{error}");
    let source = Source {
        size: [2, 2],
        levels: Vec::new(),
    };
    let error = encode(&source, &settings, &|_, _| {}).expect_err("no level");
    assert!(matches!(error, EncodeError::NoLevel));
    let linear = EncodeSettings {
        color_space: ColorSpace::Linear,
        ..settings
    };
    assert!(encode_rgb8(&[[0; 3]; 4], [2, 2], &linear).is_ok());
}

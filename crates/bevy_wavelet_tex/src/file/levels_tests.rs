//! Files without their largest levels decode to the levels that are left.

use super::{read, read_at_most, write};
use crate::codec::{
    decoder::decode,
    encoder::encode,
    image::{ColorSpace, WaveletImage},
    layout::mip_size,
    rate::Rate,
    settings::{Effort, EncodeSettings, Formats},
    source::{Pixels, Source},
};

/// A picture with slopes and edges, with mips.
fn encoded(size: [u32; 2], rate: Rate, formats: Formats) -> WaveletImage {
    let pixels: Vec<[u8; 4]> = (0..size[0] * size[1])
        .map(|i| {
            let [x, y] = [i % size[0], i / size[0]];
            let edge = 90 * ((x / 7 + y / 5) % 2);
            [x * 2 + edge, y * 3, x + y, 255 - x].map(|v| v.min(255) as u8)
        })
        .collect();
    let settings = EncodeSettings {
        rate,
        formats,
        alpha: true,
        color_space: ColorSpace::Srgb,
        effort: Effort::Fast,
        ..EncodeSettings::default()
    };
    encode(
        &Source::new(size, Pixels::Rgba8(&pixels)),
        &settings,
        &|_, _| {},
    )
    .expect("an image")
}

#[test]
fn the_levels_that_are_left_are_the_same() {
    let mut whole = 0;
    for size in [[64, 64], [93, 61], [100, 36], [37, 130], [5, 3]] {
        for rate in Rate::ALL {
            for formats in [Formats::Wavelet, Formats::Plain] {
                let image = encoded(size, rate, formats);
                let file = write(&image);
                for most in [u32::MAX, 64, 32, 20, 9, 1, 0] {
                    let smaller = read_at_most(&file, Some(most)).expect("a good file");
                    let first = image.levels - smaller.levels;
                    let name = format!("{size:?} {} {formats:?}, at most {most}", rate.name());
                    assert_eq!(smaller.size, mip_size(size, first), "{name}");
                    // What is made of it is a file again.
                    assert_eq!(read(&write(&smaller)).expect("a file"), smaller, "{name}");
                    for level in 0..smaller.levels {
                        let (a, b) = (decode(&smaller, level), decode(&image, first + level));
                        assert_eq!(a.size, b.size, "{name}: {level}");
                        let errors = a.pixels.as_flattened().iter().zip(b.pixels.as_flattened());
                        let worst = errors.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                        assert!(worst < 1e-5, "{name}: {level}: {worst}");
                        assert_eq!(a.alpha.is_some(), b.alpha.is_some(), "{name}");
                    }
                    let fits = smaller.size.iter().all(|side| *side <= most.max(1));
                    let is_scaled = image.plain.as_ref().is_some_and(|p| p.is_scaled(size));
                    assert!(fits || is_scaled, "{name}: {:?}", smaller.size);
                    whole += u32::from(fits);
                }
            }
        }
    }
    assert!(whole > 400, "{whole}");
}

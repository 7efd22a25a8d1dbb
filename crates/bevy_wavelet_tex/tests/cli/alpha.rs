//! Tests of pictures with transparent parts: what nobody sees costs nothing and shows nowhere, and what is cut
//! out keeps its size.

use image::{Rgba, RgbaImage};

use crate::Folder;

const SIZE: u32 = 256;

/// Thin leaves with soft edges, in several greens; `clear` is the colour where there are none.
fn leaves(clear: [u8; 3], edge: f32) -> RgbaImage {
    let leaf = |i: u32| {
        let random =
            |k: u32| ((i * 7 + k).wrapping_mul(2_654_435_761) >> 8) as f32 / (1 << 24) as f32;
        (
            random(0) * 256.0,
            random(1) * 256.0,
            random(2) * std::f32::consts::PI,
            random(3),
        )
    };
    let leaves: Vec<_> = (0..60).map(leaf).collect();
    RgbaImage::from_fn(SIZE, SIZE, |x, y| {
        let (mut alpha, mut shade) = (0.0, 0.0);
        for (cx, cy, angle, tone) in &leaves {
            let (dx, dy) = (x as f32 - cx, y as f32 - cy);
            let (along, across) = (
                dx * angle.cos() + dy * angle.sin(),
                dy * angle.cos() - dx * angle.sin(),
            );
            let inside = 1.0 - ((along / 22.0).powi(2) + (across / 3.5).powi(2)).sqrt();
            let own = (inside * edge + 0.5).clamp(0.0, 1.0);
            if own > alpha {
                (alpha, shade) = (own, 0.6 + 0.4 * tone + 0.1 * (along * 0.9).sin());
            }
        }
        if alpha == 0.0 {
            let [r, g, b] = clear;
            return Rgba([r, g, b, 0]);
        }
        let [r, g, b] = [50.0, 140.0, 36.0].map(|v: f32| (v * shade) as u8);
        Rgba([r, g, b, (alpha * 255.0).round() as u8])
    })
}

fn covered(image: &RgbaImage, cutoff: u8, channel: usize) -> f64 {
    let there = image.pixels().filter(|p| p[channel] >= cutoff).count();
    there as f64 / f64::from(image.width() * image.height())
}

/// Mean squared error of the colour where a picture is opaque.
fn opaque_error(a: &RgbaImage, b: &RgbaImage) -> f64 {
    let pairs = a.pixels().zip(b.pixels()).filter(|(a, _)| a[3] == 255);
    let error = |(a, b): (&Rgba<u8>, &Rgba<u8>)| {
        (0..3)
            .map(|c| (f64::from(a[c]) - f64::from(b[c])).powi(2))
            .sum::<f64>()
    };
    let errors: Vec<f64> = pairs.map(error).collect();
    errors.iter().sum::<f64>() / (3 * errors.len()) as f64
}

#[test]
fn a_cut_out_keeps_its_area_in_every_mip() {
    let f = Folder::new("coverage");
    let image = leaves([255, 0, 255], 4.0);
    f.save("leaves.png", image.clone());
    f.save("hard.png", leaves([255, 0, 255], 1000.0));
    let shape: Vec<u8> = image.pixels().map(|p| p[3]).collect();
    let mask = image::GrayImage::from_raw(SIZE, SIZE, shape).expect("a mask");
    f.save("mask.png", mask);
    for (name, options, channel, cutoff) in [
        ("leaves", "", 3, 0.5),
        ("hard", "", 3, 0.5),
        ("leaves", "--cutoff 0.3", 3, 0.3),
        ("mask", "--role mask", 0, 0.5),
    ] {
        let png = format!("{name}.png");
        let row = f.json(&format!("encode {png} a.wtex --json {options}"));
        let levels = row[0]["levels"].as_u64().expect("a number") as u32;
        let cutoff = (cutoff * 255.0_f64).ceil() as u8;
        let original = f.open(&png).into_rgba8();
        let expected = covered(&original, cutoff, channel);
        assert!((0.1..0.4).contains(&expected), "{expected}");
        for level in 0..levels {
            let decoded = f.level("a.wtex", level);
            let actual = covered(&decoded, cutoff, channel);
            // No more than one pixel in a hundred, or what whole pixels allow.
            let pixels = f64::from(decoded.width() * decoded.height());
            let most = (0.5 / pixels).max(0.01) + 1e-9;
            assert!(
                (actual - expected).abs() <= most,
                "{name} {options}, level {level}: {actual} for {expected}"
            );
        }
    }
    f.ok("encode leaves.png a.wtex --cutoff none");
    // Filtered alpha has none of what is thinner than a pixel.
    let actual = covered(&f.level("a.wtex", 6), 128, 3);
    assert_eq!(actual, 0.0);
}

#[test]
fn colours_that_nobody_sees_cost_nothing() {
    let f = Folder::new("unseen");
    let image = leaves([255, 0, 255], 4.0);
    f.save("magenta.png", image.clone());
    f.save("like.png", leaves([44, 125, 31], 4.0));
    let error = |name: &str| {
        f.ok(&format!("encode {name} a.wtex"));
        let decoded = f.level("a.wtex", 0);
        opaque_error(&image, &decoded)
    };
    let [magenta, like] = ["magenta.png", "like.png"].map(error);
    assert!(magenta < 1.3 * like, "{magenta} for {like}");
    // 16 bits are filled, too.
    f.save(
        "wide.png",
        image::DynamicImage::from(image.clone()).into_rgba16(),
    );
    let wide = error("wide.png");
    assert!(wide < 1.3 * like, "{wide} for {like}");
}

#[test]
fn no_mip_has_the_colour_of_what_nobody_sees() {
    let f = Folder::new("edges");
    // Green rectangles of odd sizes on transparent magenta.
    f.save(
        "a.png",
        RgbaImage::from_fn(SIZE, SIZE, |x, y| match (x * 5 / 64 % 3, y * 3 / 64 % 2) {
            (1, 1) => Rgba([39, 109, 30, 255]),
            _ => Rgba([255, 0, 255, 0]),
        }),
    );
    f.ok("encode a.png --rate 8");
    for level in 0..8 {
        let decoded = f.level("a.wtex", level);
        for (x, y, p) in decoded.enumerate_pixels() {
            let far = [39, 109, 30]
                .iter()
                .zip(p.0)
                .map(|(a, b): (&u8, u8)| a.abs_diff(b));
            assert!(far.max() < Some(14), "level {level}, {x}, {y}: {p:?}");
        }
    }
}

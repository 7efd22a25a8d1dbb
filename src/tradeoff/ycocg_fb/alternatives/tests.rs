//! What each of them keeps and loses.

use super::{
    super::frame::Frame, bayer::bayer, dither::threshold, fewer_pixels,
    rgb_checkerboard::rgb_checkerboard, rgb565::rgb565, y8co4cg4::y8co4cg4,
};

const ALL: [(&str, fn(&Frame) -> Frame); 6] = [
    ("fewer pixels, bilinear", fewer_pixels::bilinear),
    ("fewer pixels, bicubic", fewer_pixels::bicubic),
    ("rgb565", rgb565),
    ("y8co4cg4", y8co4cg4),
    ("bayer", bayer),
    ("rgb checkerboard", rgb_checkerboard),
];

fn mean(frame: &Frame) -> [f32; 3] {
    let count = frame.pixels.len() as f32;
    [0, 1, 2].map(|c| frame.pixels.iter().map(|p| p[c]).sum::<f32>() / count)
}

/// On average even the coarse ones, as they dither.
#[test]
fn a_flat_colour_keeps_its_mean() {
    let color = [0.8, 0.35, 0.1];
    let flat = Frame::from_fn([64, 48], |_, _| color);
    for (name, store) in ALL {
        for (a, e) in mean(&store(&flat)).into_iter().zip(color) {
            assert!((a - e).abs() < 3e-3, "{name}: {a} instead of {e}");
        }
    }
}

#[test]
fn black_and_white_are_exact() {
    for value in [0.0, 1.0] {
        let flat = Frame::from_fn([16, 16], |_, _| [value; 3]);
        for (name, store) in ALL {
            for channel in store(&flat).pixels.into_iter().flatten() {
                assert!((channel - value).abs() < 1e-6, "{name}: {channel}");
            }
        }
    }
}

/// Linear ramps in all channels, the case the filters of the mosaic are made for.
#[test]
fn the_bayer_filter_is_exact_on_a_ramp() {
    let color =
        |x: u32, y: u32| [x as f32, y as f32, (x + y) as f32 / 2.0].map(|v| (40.0 + v) / 255.0);
    let ramp = Frame::from_fn([64, 64], color);
    let shown = bayer(&ramp);
    for (x, y) in (2..62).flat_map(|y| (2..62).map(move |x| (x, y))) {
        for (a, e) in shown.at(x, y).into_iter().zip(color(x, y)) {
            // Half a step of storage, through weights whose magnitudes sum up to 2.5 at most.
            assert!((a - e).abs() <= 1.25 / 255.0, "{x} {y}: {a} instead of {e}");
        }
    }
}

#[test]
fn fewer_pixels_lose_what_is_one_pixel_wide() {
    let stripes = Frame::from_fn([48, 48], |x, _| [(x % 2) as f32; 3]);
    for store in [fewer_pixels::bilinear, fewer_pixels::bicubic] {
        let shown = store(&stripes);
        let contrast = shown
            .pixels
            .windows(2)
            .map(|p| (p[0][0] - p[1][0]).abs())
            .sum::<f32>()
            / shown.pixels.len() as f32;
        assert!(contrast < 0.7, "{contrast}");
    }
}

#[test]
fn every_threshold_of_the_matrix_occurs_once() {
    let mut ranks: Vec<i32> = (0..64)
        .map(|i| ((threshold(i % 8, i / 8) + 0.5) * 64.0) as i32)
        .collect();
    ranks.sort_unstable();
    assert!(ranks.into_iter().eq(0..64));
}

use image::{Rgb, RgbImage};

use bevy_frugal_lab::metrics::flip::*;

/// Colour bands of several widths under a diagonal ramp.
fn pattern(width: u32, height: u32) -> RgbImage {
    RgbImage::from_fn(width, height, |x, y| {
        let band = [40, 210, 120, 250, 0][(x / 5 + y / 7) as usize % 5];
        Rgb([
            band,
            (x * 6 + y * 2) as u8,
            (255 - band) / 2 + (y * 3) as u8,
        ])
    })
}

fn map(image: &RgbImage, change: impl Fn(u32, u32, [u8; 3]) -> [u8; 3]) -> RgbImage {
    RgbImage::from_fn(image.width(), image.height(), |x, y| {
        Rgb(change(x, y, image.get_pixel(x, y).0))
    })
}

/// Pairs of images with the mean error that the authors' program gives for them. The values were
/// computed in advance with the crate `nv-flip` 0.1.2, which binds that program.
fn reference_pairs() -> [(&'static str, RgbImage, RgbImage, f32, f64); 7] {
    let base = pattern(40, 24);
    let noise = map(&base, |x, y, rgb| {
        rgb.map(|c| c ^ ((x * 7 + y * 13) % 16) as u8)
    });
    let shift = map(&base, |x, y, _| base.get_pixel((x + 1).min(39), y).0);
    let swap = map(&base, |_, _, [r, g, b]| [g, b, r]);
    let mut dot = base.clone();
    dot.put_pixel(20, 12, Rgb([255, 255, 255]));
    let pixel = |rgb| RgbImage::from_pixel(1, 1, Rgb(rgb));
    let ppd = DEFAULT_PIXELS_PER_DEGREE;
    [
        ("noise", base.clone(), noise.clone(), ppd, 0.073556),
        ("shift", base.clone(), shift, ppd, 0.297927),
        ("swap", base.clone(), swap, ppd, 0.839780),
        ("dot", base.clone(), dot, ppd, 0.005746),
        ("noise, near", base.clone(), noise.clone(), 20.0, 0.162517),
        ("noise, far", base, noise, 150.0, 0.062591),
        (
            "pixel",
            pixel([200, 30, 40]),
            pixel([20, 200, 90]),
            ppd,
            0.968107,
        ),
    ]
}

#[test]
fn agrees_with_the_authors_program() {
    for (name, reference, test, pixels_per_degree, expected) in reference_pairs() {
        let mean = flip_map(&reference, &test, pixels_per_degree)
            .unwrap()
            .mean();
        assert!(
            (mean - expected).abs() < 2e-6,
            "{name}: {mean} instead of {expected}"
        );
    }
}

#[test]
fn is_symmetric_and_within_its_range() {
    for (name, reference, test, pixels_per_degree, _) in reference_pairs() {
        let forth = flip_map(&reference, &test, pixels_per_degree).unwrap();
        let back = flip_map(&test, &reference, pixels_per_degree).unwrap();
        assert_eq!(forth, back, "{name}");
        assert!(
            forth.values.iter().all(|v| (0.0..=1.0).contains(v)),
            "{name}"
        );
        assert_eq!(
            flip_map(&test, &test, pixels_per_degree).unwrap().mean(),
            0.0,
            "{name}"
        );
    }
}

#[test]
fn a_lost_edge_weighs_more_than_the_same_energy_in_fine_noise() {
    let gray = |value| Rgb([value; 3]);
    let flat = RgbImage::from_pixel(64, 64, gray(128));
    let checker = RgbImage::from_fn(64, 64, |x, y| {
        gray(if (x + y) % 2 == 0 { 118 } else { 138 })
    });
    let edge = RgbImage::from_fn(64, 64, |x, _| gray(if x < 32 { 118 } else { 138 }));
    let mean = |test| {
        flip_map(&flat, test, DEFAULT_PIXELS_PER_DEGREE)
            .unwrap()
            .mean()
    };
    assert!(
        mean(&checker) < 0.5 * mean(&edge),
        "{} {}",
        mean(&checker),
        mean(&edge)
    );
}

#[test]
fn does_not_depend_on_the_number_of_threads() {
    let [_, (_, reference, test, ppd, _), ..] = reference_pairs();
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| flip_map(&reference, &test, ppd).unwrap())
    };
    assert_eq!(on(1), on(5));
}

#[test]
fn odd_resolutions_and_empty_images_are_accepted() {
    let (a, b) = (pattern(3, 2), RgbImage::new(3, 2));
    for pixels_per_degree in [-1.0, 0.0, 1.0, 5000.0] {
        let mean = flip_map(&a, &b, pixels_per_degree).unwrap().mean();
        assert!((0.0..=1.0).contains(&mean), "{pixels_per_degree}: {mean}");
    }
    for (width, height) in [(0, 0), (0, 4), (4, 0)] {
        let empty = RgbImage::new(width, height);
        assert_eq!(flip_map(&empty, &empty, 67.0).unwrap().mean(), 0.0);
    }
}

use image::{Rgb, RgbImage};

use bevy_frugal_lab::content::*;

type Make = fn(u32, u32, u64) -> Material;

const TILING: [(&str, Make); 6] = [
    ("bricks", bricks),
    ("wood", wood),
    ("foliage", foliage),
    ("noise", noise),
    ("decals", decals),
    ("packed maps", packed_maps),
];
const SINGLE: [(&str, Make); 2] = [("text", text), ("gradients", gradients)];

fn all() -> impl Iterator<Item = (&'static str, Make)> {
    TILING.into_iter().chain(SINGLE)
}

#[test]
fn the_seed_decides_every_byte() {
    for (name, make) in all() {
        assert_eq!(make(70, 50, 7), make(70, 50, 7), "{name}");
        // A page below 512 pixels shows few words, but its paper differs.
        assert_ne!(make(70, 50, 7).color, make(70, 50, 8).color, "{name}");
        assert_ne!(
            make(70, 50, 7).color,
            make(70, 50, 7 + (1 << 40)).color,
            "{name}"
        );
    }
    assert_eq!(photo_like(60, 40, 7), photo_like(60, 40, 7));
    assert_ne!(photo_like(60, 40, 7), photo_like(60, 40, 8));
}

#[test]
fn the_number_of_threads_does_not_matter() {
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| bricks(48, 48, 1))
    };
    assert_eq!(on(1), on(4));
}

#[test]
fn any_size_is_rendered() {
    for (width, height) in [(1, 1), (1, 9), (33, 2), (101, 47), (0, 0), (0, 5), (5, 0)] {
        for (name, make) in all() {
            let material = make(width, height, 3);
            for size in [
                material.color.dimensions(),
                material.normal.dimensions(),
                material.mask.dimensions(),
            ] {
                assert_eq!(size, (width, height), "{name}");
            }
        }
        assert_eq!(photo_like(width, height, 3).dimensions(), (width, height));
    }
}

/// Mean absolute difference of neighbouring columns `x` and `x + 1`, wrapping.
fn column_step(image: &RgbImage, x: u32) -> f32 {
    let next = (x + 1) % image.width();
    let sum: u32 = (0..image.height())
        .flat_map(|y| {
            let (Rgb(a), Rgb(b)) = (image.get_pixel(x, y), image.get_pixel(next, y));
            (0..3).map(move |c| u32::from(a[c].abs_diff(b[c])))
        })
        .sum();
    sum as f32 / (image.height() * 3) as f32
}

#[test]
fn tiles_have_no_seam() {
    for (name, make) in TILING {
        for (width, height) in [(160, 160), (211, 97)] {
            let material = make(width, height, 5);
            for image in [&material.color, &material.normal] {
                for image in [image, &image::imageops::rotate90(image)] {
                    let inner = (0..image.width() - 1).map(|x| column_step(image, x));
                    let largest = inner.fold(0.0, f32::max);
                    let seam = column_step(image, image.width() - 1);
                    // A joint on the border is an edge like those inside, give or take.
                    assert!(
                        seam <= 1.1 * largest,
                        "{name}: {seam} across the seam, {largest} inside"
                    );
                }
            }
        }
    }
}

#[test]
fn normals_wrap_only_where_the_surface_does() {
    let heights = [0.0, 0.0, 0.0, 1.0].map(|height| Sample {
        height,
        ..Sample::default()
    });
    let red = |border, x| assemble(4, 1, border, &heights).normal.get_pixel(x, 0).0[0];
    // Left of the ridge the slope rises to the right, so the normal leans left; right of it, right.
    assert!(red(Border::Wrap, 2) < 127 && red(Border::Wrap, 0) > 128);
    assert_eq!((red(Border::Clamp, 0), red(Border::Clamp, 1)), (128, 128));
}

#[test]
fn normals_are_unit_vectors_that_point_out() {
    for (name, make) in all() {
        let material = make(96, 64, 2);
        let decode = |byte: u8| f32::from(byte) / 127.5 - 1.0;
        let (mut mean, mut steepest) = ([0.0; 3], 1.0f32);
        for pixel in material.normal.pixels() {
            let normal = pixel.0.map(decode);
            let length = normal.iter().map(|n| n * n).sum::<f32>().sqrt();
            // Half a step of rounding along each axis.
            assert!(
                (length - 1.0).abs() <= 3f32.sqrt() * 0.5 / 127.5,
                "{name}: {normal:?}"
            );
            assert!(normal[2] > 0.0, "{name}: {normal:?}");
            steepest = steepest.min(normal[2]);
            for c in 0..3 {
                mean[c] += normal[c] / (96.0 * 64.0);
            }
        }
        assert!(
            mean[0].abs() < 0.05 && mean[1].abs() < 0.05,
            "{name} leans: {mean:?}"
        );
        assert!(steepest < 0.98, "{name} is flat: {steepest}");
    }
}

#[test]
fn a_bump_faces_up_at_its_upper_edge() {
    // The dome of the upper left panel: green above the middle is +Y, red right of it +X.
    let normal = gradients(96, 96, 0).normal;
    let at = |x: u32, y: u32| normal.get_pixel(x, y).0;
    assert!(
        at(16, 4)[1] > 140 && at(16, 44)[1] < 115,
        "{:?} {:?}",
        at(16, 4),
        at(16, 44)
    );
    assert!(
        at(28, 24)[0] > 140 && at(4, 24)[0] < 115,
        "{:?} {:?}",
        at(28, 24),
        at(4, 24)
    );
}

/// Mean and standard deviation of the luma, 0 to 255.
fn luma(image: &RgbImage) -> (f64, f64) {
    let count = f64::from(image.width() * image.height());
    let values = || {
        image
            .pixels()
            .map(|p| p.0.map(f64::from))
            .map(|[r, g, b]| 0.299 * r + 0.587 * g + 0.114 * b)
    };
    let mean = values().sum::<f64>() / count;
    (
        mean,
        (values().map(|v| (v - mean).powi(2)).sum::<f64>() / count).sqrt(),
    )
}

#[test]
fn exposure_and_contrast_are_sane() {
    let pages = all().map(|(name, make)| (name, make(192, 192, 4).color));
    for (name, image) in pages.chain([("photo_like", photo_like(192, 128, 4))]) {
        let (mean, deviation) = luma(&image);
        let brightest = if name == "text" { 245.0 } else { 180.0 };
        assert!((40.0..brightest).contains(&mean), "{name}: mean {mean}");
        assert!(
            (12.0..100.0).contains(&deviation),
            "{name}: deviation {deviation}"
        );
    }
}

#[test]
fn masks_have_surface_and_gaps() {
    for (name, make) in all() {
        let mask = make(256, 256, 6).mask;
        let share = |inside: fn(u8) -> bool| {
            mask.pixels().filter(|p| inside(p.0[0])).count() as f32 / 65536.0
        };
        let (low, high) = (share(|v| v < 64), share(|v| v > 160));
        assert!(
            low > 0.005 && high > 0.005,
            "{name}: {low} low, {high} high"
        );
    }
}

#[test]
fn text_is_ink_on_paper() {
    let page = text(512, 512, 1);
    for (pixel, ink) in page.color.pixels().zip(page.mask.pixels()) {
        match ink.0[0] {
            0 => assert!(pixel.0.iter().all(|c| *c > 220), "{pixel:?}"),
            255 => assert!(pixel.0[1] < 100, "{pixel:?}"),
            _ => (),
        }
    }
    let ink = page.mask.iter().map(|v| f32::from(*v) / 255.0).sum::<f32>() / 262_144.0;
    assert!((0.03..0.25).contains(&ink), "{ink}");
}

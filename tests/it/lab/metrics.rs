use bevy_frugal_lab::metrics::*;
use image::{Rgb, RgbImage};

#[test]
fn equal_images_have_no_error() {
    let image = RgbImage::from_fn(19, 7, |x, y| Rgb([(x * 13) as u8, (y * 31) as u8, 90]));
    let error = compare(&image, &image).unwrap();
    let expected = ImageError {
        mse: 0.0,
        psnr_db: f64::INFINITY,
        max_error: 0,
        flip: 0.0,
    };
    assert_eq!(error, expected);
}

#[test]
fn degenerate_sizes_are_compared() {
    let none = RgbImage::new(0, 0);
    assert_eq!(compare(&none, &none).unwrap().flip, 0.0);

    let black = RgbImage::new(1, 1);
    let white = RgbImage::from_pixel(1, 1, Rgb([255; 3]));
    let error = compare(&black, &white).unwrap();
    assert_eq!(
        (error.mse, error.psnr_db, error.max_error),
        (65025.0, 0.0, 255)
    );
    assert!(error.flip > 0.9 && error.flip <= 1.0, "{error:?}");
}

#[test]
fn a_size_mismatch_names_both_sizes() {
    let error = compare(&RgbImage::new(3, 2), &RgbImage::new(2, 3)).unwrap_err();
    assert_eq!(
        error,
        SizeMismatch {
            reference: (3, 2),
            test: (2, 3)
        }
    );
    let message = error.to_string();
    assert!(
        message.contains("3x2") && message.contains("2x3"),
        "{message}"
    );
}

#[test]
fn a_constant_offset_of_one_is_48_13_db() {
    let reference = RgbImage::from_fn(17, 5, |x, y| Rgb([x as u8, y as u8, 254]));
    let test = RgbImage::from_fn(17, 5, |x, y| Rgb([x as u8 + 1, y as u8 + 1, 255]));
    let mse = mse(&reference, &test).unwrap();
    assert_eq!(mse, 1.0);
    assert!((psnr_db(mse) - 48.130_803_608_679).abs() < 1e-9);
    assert_eq!(max_error(&reference, &test), Ok(1));
}

#[test]
fn one_channel_of_one_pixel_counts_once() {
    let reference = RgbImage::from_pixel(2, 2, Rgb([100; 3]));
    let mut test = reference.clone();
    test.put_pixel(1, 0, Rgb([100, 88, 100]));
    for (a, b) in [(&reference, &test), (&test, &reference)] {
        assert_eq!(mse(a, b), Ok(144.0 / 12.0));
        assert_eq!(max_error(a, b), Ok(12));
    }
}

#[test]
fn extreme_errors_are_exact() {
    let (black, white) = (
        RgbImage::new(64, 64),
        RgbImage::from_pixel(64, 64, Rgb([255; 3])),
    );
    assert_eq!(mse(&black, &white), Ok(65025.0));
    assert_eq!(psnr_db(65025.0), 0.0);
    assert_eq!(psnr_db(0.0), f64::INFINITY);
}

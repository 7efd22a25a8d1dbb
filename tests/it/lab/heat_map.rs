use bevy_frugal_lab::metrics::{flip::FlipMap, heat_map::*};
use image::{Rgb, RgbImage};

fn luma([r, g, b]: [u8; 3]) -> f32 {
    0.299 * f32::from(r) + 0.587 * f32::from(g) + 0.114 * f32::from(b)
}

#[test]
fn magma_rises_in_brightness_from_black_to_pale_yellow() {
    let lumas: Vec<f32> = (0..=64).map(|i| luma(magma(i as f32 / 64.0).0)).collect();
    assert!(lumas.windows(2).all(|pair| pair[1] > pair[0]), "{lumas:?}");
    assert!(lumas[0] < 2.0 && lumas[64] > 240.0, "{lumas:?}");
    assert_eq!((magma(-1.0), magma(2.0)), (magma(0.0), magma(1.0)));
}

#[test]
fn gain_saturates_at_its_stated_difference() {
    let reference = RgbImage::from_pixel(2, 1, Rgb([100; 3]));
    let mut test = reference.clone();
    test.put_pixel(1, 0, Rgb([100, 68, 101]));
    let map = absolute_error_heat_map(&reference, &test, 4.0).unwrap();
    assert_eq!(*map.get_pixel(0, 0), magma(0.0));
    assert_eq!(*map.get_pixel(1, 0), magma(32.0 / 255.0 * 4.0));
    let map = absolute_error_heat_map(&reference, &test, 8.0).unwrap();
    assert_eq!(*map.get_pixel(1, 0), magma(1.0));
    assert!(absolute_error_heat_map(&reference, &RgbImage::new(1, 1), 1.0).is_err());
}

#[test]
fn a_flip_map_keeps_its_layout() {
    let map = FlipMap {
        width: 2,
        height: 2,
        values: vec![0.0, 0.25, 0.5, 1.0],
    };
    let image = flip_heat_map(&map);
    assert_eq!(*image.get_pixel(1, 0), magma(0.25));
    assert_eq!(*image.get_pixel(0, 1), magma(0.5));
}

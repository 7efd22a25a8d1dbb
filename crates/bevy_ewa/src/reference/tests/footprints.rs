//! Computation of the ellipse from derivatives.

use proptest::prelude::*;

use super::{super::exact::Ellipse, *};

#[test]
fn radii_and_direction_of_known_ellipses() {
    for degrees in [0.0f64, 20.0, 45.0, 90.0, 135.0, 170.0] {
        let angle = degrees.to_radians();
        let footprint = Footprint::new(ellipse(0.5, 0.05, angle), [64, 64], 1024.0);
        assert!((footprint.major_radius_texels - 32.0).abs() < 1e-9);
        assert!((footprint.minor_radius_texels - 3.2).abs() < 1e-9);
        assert!((footprint.anisotropy - 10.0).abs() < 1e-9);
        let (sin, cos) = angle.sin_cos();
        let [x, y] = footprint.major_direction;
        assert!((x * sin - y * cos).abs() < 1e-9, "{degrees}: {x}, {y}");
    }
}

#[test]
fn the_anisotropy_limit_widens_only_the_minor_axis() {
    let footprint = Footprint::new(ellipse(1.0, 0.001, 0.3), [256, 256], 16.0);
    assert!((footprint.major_radius_texels - 256.0).abs() < 1e-6);
    assert!((footprint.minor_radius_texels - 16.0).abs() < 1e-6);
    assert!((footprint.anisotropy - 1000.0).abs() < 1e-6);
}

#[test]
fn a_footprint_of_a_non_square_texture_is_in_its_texels() {
    let footprint = Footprint::new(ellipse(0.1, 0.1, 0.0), [400, 100], 64.0);
    assert!((footprint.major_radius_texels - 40.0).abs() < 1e-9);
    assert!((footprint.minor_radius_texels - 10.0).abs() < 1e-9);
}

proptest! {
    /// Points at a distance of one pixel project onto the ellipse of the footprint without padding.
    #[test]
    fn the_ellipse_is_the_image_of_the_circle(
        a in -2.0..2.0f64, b in -2.0..2.0f64, c in -2.0..2.0f64, d in -2.0..2.0f64,
        phase in 0.0..6.3f64,
    ) {
        prop_assume!((a * d - b * c).abs() > 0.05);
        let derivatives = Derivatives { dx: [a, c], dy: [b, d] };
        // The texture is so large that the padding of one texel is negligible.
        let size = [1 << 20; 2];
        let footprint = Footprint::new(derivatives, size, 1e9);
        let ellipse = Ellipse::new(&footprint, 1.0, [0.0; 2], 0, size, size);
        let (sin, cos) = phase.sin_cos();
        let at = [a * cos + b * sin, c * cos + d * sin].map(|t| t * f64::from(1 << 20));
        let distance = ellipse.distance_squared(at.map(|t| t as i64));
        prop_assert!((distance - 1.0).abs() < 1e-3, "{distance}");
    }

    /// A rotation of the picture does not change the footprint, because the filter is a disc.
    #[test]
    fn the_footprint_does_not_depend_on_the_axes_of_the_picture(
        a in -2.0..2.0f64, b in -2.0..2.0f64, c in -2.0..2.0f64, d in -2.0..2.0f64,
        rotation in 0.0..6.3f64,
    ) {
        prop_assume!((a * d - b * c).abs() > 0.05);
        let (sin, cos) = rotation.sin_cos();
        let plain = Derivatives { dx: [a, c], dy: [b, d] };
        let rotated = Derivatives {
            dx: [a * cos + b * sin, c * cos + d * sin],
            dy: [b * cos - a * sin, d * cos - c * sin],
        };
        let [p, t] = [plain, rotated].map(|d| Footprint::new(d, [128, 128], 64.0));
        prop_assert!((p.major_radius_texels - t.major_radius_texels).abs() < 1e-6);
        prop_assert!((p.minor_radius_texels - t.minor_radius_texels).abs() < 1e-6);
    }
}

//! The ellipse of a pixel, upper bounds of its cost, and the mip levels that it is read from.

use proptest::prelude::*;

use super::{
    super::{exact::Ellipse, footprint::max_texels, sample::sample},
    *,
};

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

#[test]
fn a_budget_raises_the_mip_level_and_never_cuts_the_ellipse() {
    // A cut ellipse would miss one side of the step; a coarser level covers both.
    let texture = Texture::from_fn([256, 256], |x, _| [f64::from(u8::from(x >= 128)); 4]);
    let derivatives = ellipse(0.4, 0.01, 0.0);
    for method in EXACT {
        let settings = EwaSettings {
            max_fetches: 40,
            ..EwaSettings::with_method(method)
        };
        let sampled = sample(&texture, [0.5, 0.5], derivatives, &settings, 0);
        assert!((sampled.color[0] - 0.5).abs() < 0.02, "{sampled:?}");
        assert!(sampled.fetches <= 40);
    }
}

#[test]
fn only_texels_inside_the_ellipse_are_fetched() {
    // An ellipse of 16:1 at 0.4 radians covers a fifth of its bounding box; pairs take half of that.
    let texture = noise([256, 256]);
    let derivatives = ellipse(16.0 / 256.0, 1.0 / 256.0, 0.4);
    let fetches = |method| {
        let settings = EwaSettings {
            minor_radius_texels: 1.0,
            level_blend: 0.0,
            ..EwaSettings::with_method(method)
        };
        sample(&texture, [0.5, 0.5], derivatives, &settings, 0).fetches
    };
    let [reference, linear, bilinear] = EXACT.map(fetches);
    assert!(reference <= 80, "{reference}");
    assert!(linear <= 45, "{linear}");
    assert!(bilinear <= 30, "{bilinear}");
}

#[test]
fn every_level_has_the_mean_of_the_texture() {
    for size in [[64, 64], [37, 21], [5, 1], [1, 9], [3, 3], [100, 7]] {
        let texture = noise(size);
        let mean = |level: &Level| {
            let sum = level.texels.iter().fold([0.0; 4], |sum, texel| {
                [0, 1, 2, 3].map(|i| sum[i] + texel[i])
            });
            sum.map(|c| c / level.texels.len() as f64)
        };
        let expected = mean(&texture.levels[0]);
        for level in &texture.levels {
            for (actual, expected) in mean(level).iter().zip(expected) {
                assert!(
                    (actual - expected).abs() < 1e-12,
                    "{size:?} {:?}",
                    level.size
                );
            }
        }
        let last = texture.levels.last().expect("a level");
        assert_eq!(last.size, [1, 1]);
    }
}

#[test]
fn sizes_are_halved_and_rounded_down() {
    let sizes: Vec<_> = noise([13, 6]).levels.iter().map(|l| l.size).collect();
    assert_eq!(sizes, [[13, 6], [6, 3], [3, 1], [1, 1]]);
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
        let ellipse = Ellipse::new(&footprint, 1.0, [0.0; 2], size, 0);
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

    #[test]
    fn an_exact_lookup_keeps_within_its_budget(
        log_major in -6.0..4.0f64, log_ratio in 0.0..8.0f64, angle in 0.0..3.2f64,
        u in 0.0..1.0f64, v in 0.0..1.0f64,
        budget in 16u32..600, method in 0usize..3, kernel in 0usize..5,
        minor_radius_texels in 0.5..4.0f32, blend in 0.0..1.0f32,
    ) {
        let texture = noise([37, 64]);
        let major = log_major.exp2();
        let derivatives = ellipse(major, major / log_ratio.exp2(), angle);
        let settings = EwaSettings {
            max_fetches: budget,
            max_anisotropy: 64.0,
            minor_radius_texels,
            level_blend: blend,
            kernel: KERNELS[kernel],
            ..EwaSettings::with_method(EXACT[method])
        };
        let sampled = sample(&texture, [u, v], derivatives, &settings, 0);
        // Kernels with negative lobes cannot always fetch pairs, but never take more than one fetch per
        // texel. The bilinear reconstruction may be blended in with one more.
        prop_assert!(sampled.fetches <= budget + 1, "{}", sampled.fetches);
    }

    #[test]
    fn no_ellipse_has_more_texels_than_the_bound(
        major in 0.0..60.0f64, ratio in 1.0..40.0f64, angle in 0.0..3.2f64,
        u in 0.0..1.0f64, v in 0.0..1.0f64,
    ) {
        let footprint = Footprint::new(ellipse(major, major / ratio, angle), [1, 1], 1e9);
        let ellipse = Ellipse::new(&footprint, 1.0, [u, v], [1, 1], 0);
        let inside = (-70..=70i64)
            .flat_map(|y| (-70..=70i64).map(move |x| [x, y]))
            .filter(|texel| ellipse.distance_squared(*texel) <= 1.0)
            .count();
        let bound = max_texels(major + 1.0, major / ratio + 1.0);
        prop_assert!(inside as f64 <= bound, "{inside} > {bound}");
    }
}

//! The ellipse of a pixel, upper bounds of its cost, and the mip levels that it is read from; errors of small pictures
//! against the ground truth, and convergence of the stochastic method to it.

use proptest::prelude::*;

use super::{
    super::{
        exact::Ellipse, footprint::max_texels, scenes::ground_truth,
        stochastic::noise as random_numbers,
    },
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
        let plain = Derivatives { dx: [a, c], dy: [b, d] };
        let [p, t] = [plain, rotated(plain, rotation)].map(|d| Footprint::new(d, [128, 128], 64.0));
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

const SIZE: u32 = 24;

/// A floor at 5 degrees.
fn floor(rotation_degrees: f64) -> Surface {
    plane(5.0, 3.0, rotation_degrees, 0.5)
}

/// Returns the mean squared error of the mean of `frames` frames against the ground truth, in squared 8-bit units of
/// linear light, and the mean fetches per pixel and frame.
fn error(texture: &Texture, surface: &Surface, settings: &EwaSettings, frames: u32) -> (f64, f64) {
    let (mut sum, mut fetches) = (0.0, 0);
    for i in 0..SIZE * SIZE {
        let pixel = [i % SIZE, i / SIZE];
        let (uv, derivatives) = surface.pixel(SIZE, pixel);
        let mut mean = 0.0;
        for frame in 0..frames {
            let sampled = sample(texture, uv, derivatives, settings, frame);
            if settings.method == EwaMethod::Stochastic {
                assert_eq!(sampled.fetches, 1);
            }
            fetches += sampled.fetches;
            mean += sampled.color[0] / f64::from(frames);
        }
        let expected = ground_truth(texture, surface, SIZE, pixel, settings.kernel, 24);
        sum += ((mean - expected[0]) * 255.0).powi(2);
    }
    let pixels = f64::from(SIZE * SIZE);
    (
        sum / pixels,
        f64::from(fetches) / pixels / f64::from(frames),
    )
}

#[test]
fn the_methods_are_ordered_on_grazing_planes() {
    let texture = checks(0.1);
    for rotation in [0.0, 45.0] {
        let surface = floor(rotation);
        let approximate = EwaMethod::Approximate { probes: FIVE };
        let [linear, bilinear, approximate, hardware, trilinear] = [
            EwaMethod::Linear,
            EwaMethod::Bilinear,
            approximate,
            EwaMethod::SoftwareAnisotropic,
            EwaMethod::Hardware,
        ]
        .map(|method| error(&texture, &surface, &EwaSettings::with_method(method), 1));
        println!("{rotation}: {linear:?} {bilinear:?} {approximate:?} {hardware:?} {trilinear:?}");
        assert!(linear.0 < 10.0);
        assert!(bilinear.0 < 1.5 * linear.0 + 3.0 && bilinear.1 < linear.1);
        assert!(linear.0 < approximate.0 && approximate.0 < hardware.0);
        assert!(linear.0 < trilinear.0);
    }
}

#[test]
fn derivatives_are_continuous_at_the_seam_of_the_tunnel() {
    // u wraps around between these two pixels.
    let [(above, a), (below, b)] = [[3, 31], [3, 32]].map(|pixel| TUNNEL.pixel(64, pixel));
    assert!((above[0] - below[0]).abs() > 3.0);
    assert!((a.dy[0] - b.dy[0]).abs() < 1e-6, "{a:?} {b:?}");
}

#[test]
fn the_mean_of_frames_converges_to_the_truth() {
    let (texture, surface) = (checks(0.1), floor(45.0));
    for kernel in [EwaKernel::Box, EwaKernel::Tent, EwaKernel::default()] {
        let settings = EwaSettings {
            kernel,
            ..EwaSettings::with_method(EwaMethod::Stochastic)
        };
        let errors =
            [1, 8, 16, 64, 512].map(|frames| error(&texture, &surface, &settings, frames).0);
        println!("{kernel:?}: {errors:.1?} after 1, 8, 16, 64 and 512 frames");
        // Faster than independent random numbers, whose error falls as 1 / frames.
        assert!(errors[1] < errors[0] / 8.0, "{errors:?}");
        assert!(
            errors[2] < errors[1] && errors[3] < 0.5 * errors[2],
            "{errors:?}"
        );
        assert!(errors[4] < 15.0, "{errors:?}");
    }
}

#[test]
fn numbers_are_even_and_differ_between_pixels() {
    let mean = |numbers: &[f64]| numbers.iter().sum::<f64>() / numbers.len() as f64;
    for i in 0..2 {
        let frames: Vec<_> = (0..64)
            .map(|frame| random_numbers([0.3, 0.7], frame)[i])
            .collect();
        assert!((mean(&frames) - 0.5).abs() < 0.02);
        let pixels = (0..1000).map(|x| random_numbers([f64::from(x) * 0.01, 0.4], 0)[i]);
        let pixels: Vec<_> = pixels.collect();
        assert!((mean(&pixels) - 0.5).abs() < 0.05);
        let squares: Vec<_> = pixels.iter().map(|n| (n - 0.5) * (n - 0.5)).collect();
        assert!((mean(&squares) - 1.0 / 12.0).abs() < 0.01);
        assert!(pixels.iter().all(|n| (0.0..1.0).contains(n)));
    }
}

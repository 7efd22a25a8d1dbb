//! Errors of small pictures against the ground truth, and convergence of the stochastic method to it.

use super::{
    super::{
        ground_truth::ground_truth, sample::sample, scenes::Surface,
        stochastic::noise as random_numbers,
    },
    *,
};

const SIZE: u32 = 24;

/// A checkerboard in linear light.
fn checks() -> Texture {
    Texture::from_fn([256, 256], |x, y| {
        let v = if (x / 32 + y / 32) % 2 == 0 { 0.9 } else { 0.1 };
        [v, v, v, 1.0]
    })
}

/// A floor at 5 degrees, whose texture is rotated.
fn floor(rotation_degrees: f64) -> Surface {
    Surface::Plane {
        grazing_angle: 5f64.to_radians(),
        tan_half_fov: 3f64.to_radians().tan(),
        rotation: rotation_degrees.to_radians(),
        scale: 0.5,
        camera_position: 0.0,
    }
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
    let texture = checks();
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
    let surface = Surface::Tunnel {
        tan_half_fov: 1.0,
        around: 4.0,
        along: 0.5,
        camera_position: 0.0,
    };
    // u wraps around between these two pixels.
    let [(above, a), (below, b)] = [[3, 31], [3, 32]].map(|pixel| surface.pixel(64, pixel));
    assert!((above[0] - below[0]).abs() > 3.0);
    assert!((a.dy[0] - b.dy[0]).abs() < 1e-6, "{a:?} {b:?}");
}

#[test]
fn the_mean_of_frames_converges_to_the_truth() {
    let (texture, surface) = (checks(), floor(45.0));
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

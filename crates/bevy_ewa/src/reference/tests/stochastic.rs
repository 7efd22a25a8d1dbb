//! The mean of random fetches is the filter.

use super::{
    super::{ground_truth::ground_truth, sample::sample, scenes::Surface, stochastic::noise},
    *,
};

const SIZE: u32 = 24;

fn floor() -> Surface {
    Surface::Plane {
        grazing_angle: 5f64.to_radians(),
        tan_half_fov: 3f64.to_radians().tan(),
        rotation: 45f64.to_radians(),
        scale: 0.5,
        camera_position: 0.0,
    }
}

/// Returns the mean squared error of the mean of `frames` frames against the ground truth, in squared 8-bit units.
fn error(texture: &Texture, settings: &EwaSettings, frames: u32) -> f64 {
    let surface = floor();
    let mut sum = 0.0;
    for i in 0..SIZE * SIZE {
        let pixel = [i % SIZE, i / SIZE];
        let (uv, derivatives) = surface.pixel(SIZE, pixel);
        let values = (0..frames).map(|frame| {
            let found = sample(texture, uv, derivatives, settings, frame);
            assert_eq!(found.fetches, 1);
            found.color[0]
        });
        let mean = values.sum::<f64>() / f64::from(frames);
        let wanted = ground_truth(texture, &surface, SIZE, pixel, settings.kernel, 24);
        sum += ((mean - wanted[0]) * 255.0).powi(2);
    }
    sum / f64::from(SIZE * SIZE)
}

#[test]
fn the_mean_of_frames_converges_to_the_truth() {
    let texture = Texture::from_fn([256, 256], |x, y| {
        let v = if (x / 32 + y / 32) % 2 == 0 { 0.9 } else { 0.1 };
        [v, v, v, 1.0]
    });
    for kernel in [EwaKernel::Box, EwaKernel::Tent, EwaKernel::default()] {
        let settings = EwaSettings {
            kernel,
            ..EwaSettings::with_method(EwaMethod::Stochastic)
        };
        let errors = [1, 8, 16, 64, 512].map(|frames| error(&texture, &settings, frames));
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
        let frames: Vec<_> = (0..64).map(|frame| noise([0.3, 0.7], frame)[i]).collect();
        assert!((mean(&frames) - 0.5).abs() < 0.02);
        let pixels = (0..1000).map(|x| noise([f64::from(x) * 0.01, 0.4], 0)[i]);
        let pixels: Vec<_> = pixels.collect();
        assert!((mean(&pixels) - 0.5).abs() < 0.05);
        let squares: Vec<_> = pixels.iter().map(|n| (n - 0.5) * (n - 0.5)).collect();
        assert!((mean(&squares) - 1.0 / 12.0).abs() < 0.01);
        assert!(pixels.iter().all(|n| (0.0..1.0).contains(n)));
    }
}

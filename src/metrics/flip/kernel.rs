//! The filter kernels of FLIP as functions of the viewer's resolution.

use std::f32::consts::PI;

use super::color::YCxCz;
use super::plane::Plane;

/// Gaussians of the contrast sensitivity functions as (a, b) of `a sqrt(π/b) exp(-π² x² / b)`,
/// x in degrees, with the paper's values. The blue-yellow one is a sum of two.
const ACHROMATIC: (f32, f32) = (1.0, 0.0047);
const RED_GREEN: (f32, f32) = (1.0, 0.0053);
const BLUE_YELLOW: [(f32, f32); 2] = [(34.1, 0.04), (13.5, 0.025)];

/// Width of the feature detectors in degrees, w in the paper.
const FEATURE_WIDTH_DEGREES: f32 = 0.082;

/// The contrast sensitivity filter: what is left of a pattern at the eye's resolution.
pub(super) struct SpatialKernel {
    achromatic: Vec<f32>,
    red_green: Vec<f32>,
    blue_yellow: [Vec<f32>; 2],
}

impl SpatialKernel {
    /// Kernels of three standard deviations of the widest Gaussian.
    pub fn new(pixels_per_degree: f32) -> Self {
        let sigma_degrees = (BLUE_YELLOW[0].1 / (2.0 * PI * PI)).sqrt();
        let radius = (3.0 * sigma_degrees * pixels_per_degree).ceil() as i32;
        let gaussian = |(a, b): (f32, f32)| -> Vec<f32> {
            // The square root of the amplitude: a kernel is applied once along each axis.
            let amplitude = (a * (PI / b).sqrt()).sqrt();
            taps(radius, |x| {
                let degrees = x / pixels_per_degree;
                amplitude * (-PI * PI * degrees * degrees / b).exp()
            })
        };
        let normalized = |mut kernel: Vec<f32>, integral: f32| {
            kernel
                .iter_mut()
                .for_each(|weight| *weight /= integral.sqrt());
            kernel
        };
        // Integral over the plane of a kernel applied along both axes.
        let integral = |kernel: &[f32]| kernel.iter().sum::<f32>().powi(2);

        let (achromatic, red_green) = (gaussian(ACHROMATIC), gaussian(RED_GREEN));
        let (achromatic_sum, red_green_sum) = (integral(&achromatic), integral(&red_green));
        let blue_yellow = BLUE_YELLOW.map(gaussian);
        let blue_yellow_sum = blue_yellow.iter().map(|kernel| integral(kernel)).sum();
        Self {
            achromatic: normalized(achromatic, achromatic_sum),
            red_green: normalized(red_green, red_green_sum),
            blue_yellow: blue_yellow.map(|kernel| normalized(kernel, blue_yellow_sum)),
        }
    }

    /// Filters every channel by its own sensitivity.
    pub fn apply(&self, image: &YCxCz) -> YCxCz {
        let both_axes =
            |plane: &Plane, kernel: &[f32]| plane.filter_rows(kernel).filter_columns(kernel);
        YCxCz {
            y: both_axes(&image.y, &self.achromatic),
            cx: both_axes(&image.cx, &self.red_green),
            cz: Plane::sum(
                &both_axes(&image.cz, &self.blue_yellow[0]),
                &both_axes(&image.cz, &self.blue_yellow[1]),
            ),
        }
    }
}

/// Detectors of edges and points: a Gaussian and its first two derivatives.
pub(super) struct FeatureKernel {
    /// Sums to 1.
    pub gaussian: Vec<f32>,
    /// First derivative; its positive and its negative weights sum to 1 and -1.
    pub edge: Vec<f32>,
    /// Second derivative; its positive and its negative weights sum to 1 and -1.
    pub point: Vec<f32>,
}

impl FeatureKernel {
    /// Kernels of three standard deviations.
    pub fn new(pixels_per_degree: f32) -> Self {
        let sigma = 0.5 * FEATURE_WIDTH_DEGREES * pixels_per_degree;
        let radius = (3.0 * sigma).ceil() as i32;
        let gaussian = |x: f32| (-x * x / (2.0 * sigma * sigma)).exp();
        Self {
            gaussian: balanced(taps(radius, gaussian)),
            edge: balanced(taps(radius, |x| -x * gaussian(x))),
            point: balanced(taps(radius, |x| {
                (x * x / (sigma * sigma) - 1.0) * gaussian(x)
            })),
        }
    }
}

/// Samples `f` at the integers from `-radius` to `radius`.
fn taps(radius: i32, f: impl Fn(f32) -> f32) -> Vec<f32> {
    (-radius..=radius).map(|x| f(x as f32)).collect()
}

/// Scales positive weights to sum to 1 and negative ones to sum to -1.
fn balanced(mut kernel: Vec<f32>) -> Vec<f32> {
    let positive: f32 = kernel.iter().filter(|weight| **weight > 0.0).sum();
    let negative: f32 = kernel.iter().filter(|weight| **weight < 0.0).sum();
    for weight in &mut kernel {
        if *weight != 0.0 {
            *weight /= if *weight > 0.0 { positive } else { -negative };
        }
    }
    kernel
}

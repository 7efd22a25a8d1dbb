//! The weight of a texel by the reconstruction kernel.

use std::f64::consts::PI;

use crate::settings::EwaKernel;

/// Value of a Gaussian at twice its standard deviation.
const GAUSSIAN_EDGE: f64 = 0.135_335_283_236_612_7;

/// Returns the weight at a squared distance from the centre, relative to the kernel's squared radius. It
/// is 0 outside of 0 to 1.
pub fn weight(kernel: EwaKernel, distance_squared: f64) -> f64 {
    if !(0.0..1.0).contains(&distance_squared) {
        return 0.0;
    }
    let distance = distance_squared.sqrt();
    match kernel {
        EwaKernel::Box => 1.0,
        EwaKernel::Tent => 1.0 - distance,
        EwaKernel::Gaussian { .. } => (-2.0 * distance_squared).exp() - GAUSSIAN_EDGE,
        EwaKernel::MitchellNetravali => mitchell_netravali(2.0 * distance),
        EwaKernel::Lanczos => sinc(2.0 * distance) * sinc(distance),
    }
}

/// The cubic with B = C = 1/3, for `x` from 0 to 2.
fn mitchell_netravali(x: f64) -> f64 {
    if x < 1.0 {
        (7.0 * x * x * x - 12.0 * x * x + 16.0 / 3.0) / 6.0
    } else {
        (-7.0 / 3.0 * x * x * x + 12.0 * x * x - 20.0 * x + 32.0 / 3.0) / 6.0
    }
}

fn sinc(x: f64) -> f64 {
    if x.abs() < 1e-6 {
        1.0
    } else {
        (PI * x).sin() / (PI * x)
    }
}

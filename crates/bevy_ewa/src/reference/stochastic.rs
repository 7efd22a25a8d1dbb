//! One trilinear fetch at a random point of the ellipse, chosen with the weights of the kernel. Its mean over
//! frames is the filter (M. Pharr et al., "Filtering After Shading with Stochastic Texture Filtering", 2024).

use std::f64::consts::TAU;

use super::{
    footprint::Footprint,
    texture::{Color, Texture},
};
use crate::settings::{EwaKernel, EwaSettings};

/// The fractions of the R2 sequence (M. Roberts, 2018), which covers a square evenly.
const SEQUENCE: [f64; 2] = [0.754_877_666, 0.569_840_296];

/// Returns two numbers from 0 to below 1 for a lookup in a frame. The frames are a sequence that covers the
/// square evenly, from a start that depends on the lookup.
pub fn noise(uv: [f64; 2], frame: u32) -> [f64; 2] {
    let [u, v] = uv.map(|c| (c as f32).to_bits());
    let first = pcg(pcg(u) ^ v);
    let start = [first, pcg(first)].map(|hash| f64::from(hash >> 8) / f64::from(1 << 24));
    [0, 1].map(|i| (start[i] + f64::from(frame & 1023) * SEQUENCE[i]).fract())
}

/// The hash PCG (M. O'Neill, 2014) in the form of M. Jarzynski and M. Olano (2020).
fn pcg(value: u32) -> u32 {
    let state = value.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

/// Filters by one fetch, at the point of the ellipse that `noise` chooses.
pub fn stochastic(
    texture: &Texture,
    footprint: &Footprint,
    uv: [f64; 2],
    settings: &EwaSettings,
    noise: [f64; 2],
) -> Color {
    let last = f64::from(texture.last_level());
    let unclamped = footprint.lod(settings);
    let lod = unclamped.clamp(0.0, last);
    let mut level = lod.floor();
    let blend = f64::from(settings.level_blend);
    if blend > 0.0 && level < last {
        level += ((lod - level - 1.0) / blend + 1.0).clamp(0.0, 1.0);
    }
    // Beyond the coarsest level the ellipse is not widened any further.
    let excess = (-(unclamped - last).max(0.0)).exp2();
    // Weights below 0 have no probability: a Gaussian replaces kernels that have them.
    let radius = match settings.kernel {
        EwaKernel::MitchellNetravali | EwaKernel::Lanczos => settings.kernel.probe_radius_pixels(),
        kernel => kernel.radius_pixels(),
    };
    let radius = f64::from(radius) * excess;
    let distance = radius * kernel_distance(settings.kernel, noise[0]);
    let (sin, cos) = (TAU * noise[1]).sin_cos();
    let along = distance * cos * footprint.major_radius_texels;
    let across = distance * sin * footprint.minor_radius_texels;
    let [c, s] = footprint.major_direction;
    let size = texture.size();
    let at = [
        uv[0] + (along * c - across * s) / f64::from(size[0]),
        uv[1] + (along * s + across * c) / f64::from(size[1]),
    ];
    texture.trilinear(at, level)
}

/// Returns the distance from the centre, relative to the radius, below which the kernel has the fraction `u` of its
/// weight.
fn kernel_distance(kernel: EwaKernel, u: f64) -> f64 {
    match kernel {
        EwaKernel::Box => u.sqrt(),
        EwaKernel::Tent => 0.5 - ((1.0 - 2.0 * u).asin() / 3.0).sin(),
        // A polynomial that is fitted to the square; its largest error is 0.0009.
        EwaKernel::Gaussian { .. } | EwaKernel::MitchellNetravali | EwaKernel::Lanczos => {
            let t = (1.0 - u).sqrt();
            (1.0 - t * (1.464_72 - t * (0.629_05 - t * 0.164_33)))
                .max(0.0)
                .sqrt()
        }
    }
}

//! Ground truth of a picture by supersampling.

use super::{
    exact::weight,
    scenes::Surface,
    texture::{Color, Texture, add_weighted},
};
use crate::settings::EwaKernel;

/// Computes the colour of a pixel from `rate` times `rate` samples per pixel of the texture's finest
/// level, with bilinear reconstruction and a kernel on the screen.
pub fn ground_truth(
    texture: &Texture,
    surface: &Surface,
    size: u32,
    pixel: [u32; 2],
    kernel: EwaKernel,
    rate: u32,
) -> Color {
    let radius = f64::from(kernel.radius_pixels());
    let half = (radius * f64::from(rate)).ceil() as i64;
    let texels = texture.size().map(f64::from);
    let (mut sum, mut total) = ([0.0; 4], 0.0);
    for j in -half..half {
        for i in -half..half {
            let offset = jittered(i, j).map(|p| p / f64::from(rate));
            let distance = offset[0].hypot(offset[1]) / radius;
            let w = weight(kernel, distance * distance);
            if w == 0.0 {
                continue;
            }
            let at = [0, 1].map(|k| f64::from(pixel[k]) + 0.5 + offset[k]);
            let uv = surface.at(size, at);
            sum = add_weighted(
                sum,
                texture.bilinear(0, [0, 1].map(|k| uv[k] * texels[k])),
                w,
            );
            total += w;
        }
    }
    sum.map(|c| c / total)
}

/// Returns a random point of a cell: regular samples would alias with checkerboards.
fn jittered(i: i64, j: i64) -> [f64; 2] {
    let mut hash = (i as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ (j as u64).rotate_left(32);
    let mut random = || {
        hash ^= hash >> 30;
        hash = hash.wrapping_mul(0xbf58_476d_1ce4_e5b9);
        hash ^= hash >> 27;
        hash = hash.wrapping_mul(0x94d0_49bb_1331_11eb);
        hash ^= hash >> 31;
        (hash >> 11) as f64 / (1u64 << 53) as f64
    };
    [i as f64 + random(), j as f64 + random()]
}

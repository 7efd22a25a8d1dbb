//! Three maps in one image, as materials have them: channels that have nothing in common.

use super::lattice::{Noise, smoothstep};
use super::material::{Border, Material, Sample, render, units};

/// Occlusion in R (smooth), roughness in G (scratches and stains of all scales), metallic in B (sharp
/// regions of all or nothing), as glTF packs them. Tiles; the mask is the metal.
pub fn packed_maps(width: u32, height: u32, seed: u64) -> Material {
    let noise = Noise::new(seed, units(width, height));
    render(width, height, Border::Wrap, |point| sample(noise, point))
}

fn sample(noise: Noise, point: [f32; 2]) -> Sample {
    // Noise is 0 on its lattice, which the border of the image is not on.
    let point = point.map(|p| p + 0.137);
    let fractal = |stream, scale, octaves| {
        let noise = noise.stream(stream);
        noise.fractal(point, [scale; 2], octaves)
    };
    let hollow = smoothstep(0.1, 0.5, fractal(1, 4, 3));
    let scratch = smoothstep(0.05, 0.0, fractal(2, 19, 3).abs());
    let stain = fractal(3, 7, 7);
    let metal = smoothstep(-0.02, 0.02, fractal(4, 9, 2) - 0.05);
    let occlusion = 1.0 - 0.7 * hollow;
    let roughness = (0.55 + 0.35 * stain - 0.3 * scratch).clamp(0.0, 1.0);
    Sample {
        color: [occlusion, roughness, metal],
        height: -0.06 * hollow - 0.006 * scratch,
        mask: metal,
    }
}

//! Fractal rock: detail of every scale, without edges or structure to hold on to.

use super::color::{Color, hex, mix, ramp, shade};
use super::lattice::{Noise, smoothstep};
use super::material::{Border, Material, Sample, render, units};

const STONE: [Color; 6] = [
    hex(0x2E2A2C),
    hex(0x5A4E48),
    hex(0x7E7468),
    hex(0x8B8D88),
    hex(0xB8AE98),
    hex(0xE3DCCB),
];
const LICHEN: Color = hex(0xA9A14C);
const RUST: Color = hex(0x8A4B26);

/// Rock from domain-warped fractal noise (1/f spectrum in brightness, independent stains in
/// colour): the hardest of these textures to compress. Tiles; the mask is the relief.
pub fn noise(width: u32, height: u32, seed: u64) -> Material {
    let noise = Noise::new(seed, units(width, height));
    render(width, height, Border::Wrap, |point| sample(noise, point))
}

fn sample(noise: Noise, point: [f32; 2]) -> Sample {
    let warp = |stream| 0.05 * noise.stream(stream).fractal(point, [3, 3], 5);
    let warped = [point[0] + warp(1), point[1] + warp(2)];
    let relief = noise.stream(3).fractal(warped, [3, 3], 9);
    // Where the absolute value of noise vanishes lie cracks.
    let crack = smoothstep(
        0.016,
        0.003,
        noise.stream(4).fractal(warped, [2, 2], 7).abs(),
    );
    let detail = noise.stream(8).fractal(warped, [22, 22], 5);
    let crystal = noise.stream(5).fractal(point, [137, 171], 2);

    let mut color = ramp(&STONE, 0.5 + 0.6 * relief + 0.35 * detail + 0.16 * crystal);
    let stain = |stream| noise.stream(stream).fractal(warped, [4, 4], 6);
    color = mix(color, RUST, 0.6 * smoothstep(0.15, 0.7, stain(6)));
    color = mix(
        color,
        LICHEN,
        0.75 * smoothstep(0.3, 0.5, stain(7) + 0.2 * detail + 0.15 * crystal),
    );
    color = mix(color, shade(color, 0.35), 0.8 * crack);

    let height = 0.05 * relief + 0.008 * detail - 0.012 * crack + 0.0006 * crystal;
    Sample {
        color,
        height,
        mask: 0.5 + 0.5 * relief - 0.3 * crack,
    }
}

//! Smooth ramps, in which banding and quantisation show first, painted signs, and fractal rock.

use crate::content::{
    lattice::{Noise, lerp, smoothstep},
    material::{Border, Material, Sample, render, units},
    texture::{Color, hex, hue, mix, ramp, shade},
};

const DUSK: [Color; 5] = [
    hex(0x101A3A),
    hex(0x3A3F73),
    hex(0xA8627E),
    hex(0xF0A36B),
    hex(0xFBE3B0),
];

/// Six panels in two rows. Top: all hues against brightness, a dusk sky, a glow in the dark.
/// Bottom: the eight darkest grays stretched over a panel, a saturated crossfade of four colours,
/// and a grayscale. Panels that would be the same for every seed are turned by it. Does not tile;
/// the normals are one smooth dome per panel, the mask is a radial falloff.
pub fn gradients(width: u32, height: u32, seed: u64) -> Material {
    let turn = (seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 40) as f32 / (1u64 << 24) as f32;
    let units = units(width, height).map(|units| units as f32);
    render(width, height, Border::Clamp, |[x, y]| {
        gradient_sample(x / units[0], y / units[1], turn)
    })
}

/// The sample at a point of the unit square.
fn gradient_sample(x: f32, y: f32, turn: f32) -> Sample {
    let (column, row) = ((x * 3.0).floor().min(2.0), (y * 2.0).floor().min(1.0));
    let (s, t) = (x * 3.0 - column, y * 2.0 - row);
    let radius = (s - 0.5).hypot(t - 0.5) * std::f32::consts::SQRT_2;

    let color = match (row as u32, column as u32) {
        (0, 0) => {
            let pure = hue(s + turn);
            if t < 0.5 {
                shade(pure, t * 2.0)
            } else {
                mix(pure, [1.0; 3], t * 2.0 - 1.0)
            }
        }
        (0, 1) => ramp(&DUSK, t + 0.08 * (s - 0.5)),
        (0, _) => shade(
            mix(hue(turn), [1.0; 3], 0.6),
            (1.0 - radius).max(0.0).powi(2) * 0.7,
        ),
        (_, 0) => [lerp(0.0, 8.0 / 255.0, s); 3],
        (_, 1) => {
            let corner = |quarter: f32| hue(turn + quarter);
            mix(
                mix(corner(0.0), corner(0.25), s),
                mix(corner(0.5), corner(0.75), s),
                t,
            )
        }
        _ => [lerp(1.0, 0.0, t); 3],
    };
    let wave = |v: f32| (v * std::f32::consts::PI).sin();
    Sample {
        color,
        height: 0.06 * wave(s) * wave(t),
        mask: 1.0 - radius,
    }
}

/// Saturated colours whose luma (R + 2 G + B) / 4 is 0.45, in sRGB: an edge between any two of them
/// is one of chroma alone.
const PAINTS: [Color; 5] = [
    [0.9, 0.2, 0.5],
    [0.1, 0.6, 0.5],
    [0.5, 0.2, 0.9],
    [0.2, 0.45, 0.7],
    [1.0, 0.4, 0.0],
];
const LIGHT: Color = [0.93, 0.92, 0.88];
const DARK: Color = [0.09, 0.09, 0.11];
const CELLS: i32 = 6;

/// Panels of flat paint with discs, rings, stripes and chevrons of another paint of the same luma, and
/// thin lines of all paints across them. Tiles; the mask is the shapes.
pub fn decals(width: u32, height: u32, seed: u64) -> Material {
    let units = units(width, height);
    let noise = Noise::new(seed, units);
    let cells = units.map(|units| units * CELLS);
    render(width, height, Border::Wrap, |point| {
        decal_sample(noise, cells, point)
    })
}

fn decal_sample(noise: Noise, cells: [i32; 2], point: [f32; 2]) -> Sample {
    // No edge between panels lies on the border of the image.
    let scaled = point.map(|p| p * CELLS as f32 + 0.25);
    let cell = [0, 1].map(|i| (scaled[i].floor() as i32).rem_euclid(cells[i]));
    let [x, y] = scaled.map(|p| p - p.floor() - 0.5);
    let choice = |stream: u32| noise.stream(stream).uniform(cell[0], cell[1]);
    let paint = |v: f32| ((v * PAINTS.len() as f32) as usize).min(PAINTS.len() - 1);
    let ground = paint(choice(1));
    let other = (ground + 1 + (choice(2) * 4.0) as usize % 4) % PAINTS.len();
    let radius = x.hypot(y);
    let is_shape = match (choice(3) * 4.0) as u32 {
        0 => radius < 0.3,
        1 => (0.22..0.36).contains(&radius),
        2 => ((x + y) * 6.0).rem_euclid(1.0) < 0.5,
        _ => ((y + x.abs()) * 4.0).rem_euclid(1.0) < 0.4,
    };
    // Shapes end before the panel does.
    let is_inside = is_shape && x.abs().max(y.abs()) < 0.4;
    let mut color = PAINTS[if is_inside { other } else { ground }];
    if radius < 0.1 {
        color = if choice(4) < 0.5 { LIGHT } else { DARK };
    }
    // Lines a pixel or two wide, in the middle of some cells.
    let line = if choice(5) < 0.5 { x } else { y };
    if choice(6) < 0.6 && (line - 0.42).abs() < 0.008 {
        color = PAINTS[paint(choice(7))];
    }
    Sample {
        color,
        height: if is_inside { 0.01 } else { 0.0 },
        mask: if is_inside { 1.0 } else { 0.0 },
    }
}

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
    render(width, height, Border::Wrap, |point| {
        noise_sample(noise, point)
    })
}

fn noise_sample(noise: Noise, point: [f32; 2]) -> Sample {
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

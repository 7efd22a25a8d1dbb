//! Decals on flat colour: what game textures have and photographs lack.

use super::color::Color;
use super::lattice::Noise;
use super::material::{Border, Material, Sample, render, units};

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
        sample(noise, cells, point)
    })
}

fn sample(noise: Noise, cells: [i32; 2], point: [f32; 2]) -> Sample {
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

//! A floor of sawn planks.

use crate::content::{
    lattice::{Noise, smoothstep},
    material::{Border, Material, Sample, render, units},
    texture::{Color, hex, mix, ramp, shade},
};

/// Planks across a unit, and planks end to end along one.
const PLANKS_PER_UNIT: [i32; 2] = [1, 5];
/// Width of a plank in units.
const PLANK_WIDTH: f32 = 1.0 / PLANKS_PER_UNIT[1] as f32;

const HEARTWOOD: [Color; 4] = [hex(0x4E2F1A), hex(0x7D512D), hex(0xA6743F), hex(0xC79A62)];
const GAP: Color = hex(0x17100B);

/// Planks with annual rings, pores, knots, nails and wear, running along x. Tiles; the mask is the
/// planks, without the gaps between them.
pub fn wood(width: u32, height: u32, seed: u64) -> Material {
    let noise = Noise::new(seed, units(width, height));
    render(width, height, Border::Wrap, |point| sample(noise, point))
}

fn sample(noise: Noise, [x, y]: [f32; 2]) -> Sample {
    let row = (y / PLANK_WIDTH).floor() as i32;
    let [_, row_id] = noise.wrap([0, row], PLANKS_PER_UNIT);
    // Every row of planks is joined at its own place.
    let along = x + noise.stream(1).uniform(0, row_id);
    let [column, _] = noise.wrap([along.floor() as i32, 0], PLANKS_PER_UNIT);
    let random = |i: u32| noise.stream(10 + i).uniform(column, row_id);
    let across = y / PLANK_WIDTH - row as f32;
    // Each plank is cut from another tree; repeating with the tile, it need not be shifted.
    let tree = noise.stream(100 + (column * 64 + row_id) as u32);

    let knot = Knot::at(along - along.floor(), across, [random(0), random(1)]);
    let point = [x, y];
    let grain = [x, y + (knot.across - across) * PLANK_WIDTH];
    // A flat-sawn board shows the rings as long contours of a slowly varying field.
    let rings = 5.0 * tree.fractal(grain, [1, 3], 2)
        + (7.0 + 6.0 * random(2)) * (knot.across - 0.5 + 0.3 * (random(3) - 0.5))
        + 0.35 * tree.stream(1).fractal(grain, [5, 24], 3)
        + knot.rings;
    let phase = rings - rings.floor();
    // Early wood darkens slowly into late wood, which ends abruptly.
    let late = smoothstep(0.15, 0.9, phase) * smoothstep(1.0, 0.94, phase);
    let fibre = tree.stream(2).fractal(grain, [6, 130], 3);
    let pore = smoothstep(0.25, 0.55, tree.stream(3).fractal(grain, [9, 150], 2)) * (0.4 + late);
    let figure = tree.stream(4).fractal(point, [3, 6], 4);

    let tone = 0.62 + 0.3 * (random(4) - 0.5) - 0.34 * late + 0.3 * fibre + 0.12 * figure;
    let mut color = ramp(&HEARTWOOD, tone - 0.55 * knot.dark);
    color = mix(color, shade(color, 0.5), 0.75 * pore);
    color = shade(color, 0.88 + 0.24 * random(5));

    // Distance to the plank's outline in units, with a slightly ragged edge.
    let end = (along - along.floor()).min(along.floor() + 1.0 - along);
    let side = across.min(1.0 - across) * PLANK_WIDTH;
    let inside =
        side.min(end) - 0.0016 - 0.0010 * (1.0 + noise.stream(2).fractal(point, [24, 24], 3));
    let cover = smoothstep(0.0, 0.003, inside);

    let nail = nail(end, side);
    color = mix(color, shade(hex(0x55504B), 0.75 + 0.5 * fibre), nail.head);
    color = mix(color, GAP, 0.6 * nail.rim);
    // Dirt gathers along the edges; feet bleach the middle.
    let dirt = noise.stream(3).fractal(point, [3, 3], 6);
    let grime = smoothstep(0.03, 0.0, inside) * 0.5 + smoothstep(0.2, 0.8, dirt) * 0.35;
    color = mix(color, shade(GAP, 1.6), grime);
    color = mix(
        color,
        hex(0xBBA588),
        0.35 * smoothstep(0.1, 0.8, -dirt + 0.4 * fibre),
    );
    let scratch = noise
        .stream(4)
        .gradient([x + 0.4 * y, y - 0.3 * x], [3, 3])
        .abs();
    color = shade(color, 1.0 + 0.1 * smoothstep(0.03, 0.0, scratch) * fibre);

    let face = 0.012 * smoothstep(0.0, 0.008, inside) + 0.0010 * late + 0.0008 * fibre
        - 0.0022 * pore
        - 0.002 * knot.dark
        + 0.0015 * nail.head
        - 0.002 * nail.rim
        + 0.004 * (random(6) - 0.5) * cover;
    Sample {
        color: mix(GAP, color, cover),
        height: face,
        mask: cover,
    }
}

/// The root of a branch, around which the grain flows.
struct Knot {
    /// Where across the plank the grain at this point would run without the knot, 0 to 1.
    across: f32,
    /// Rings of the branch itself.
    rings: f32,
    /// Darkness, 0 to 1.
    dark: f32,
}

impl Knot {
    /// The knot of a plank, at a point `along` and `across` it, both 0 to 1. Not every plank has one.
    fn at(along: f32, across: f32, random: [f32; 2]) -> Self {
        const RADIUS: f32 = 0.1;
        if random[1] > 0.65 {
            return Self {
                across,
                rings: 0.0,
                dark: 0.0,
            };
        }
        let center = 0.3 + 0.6 * random[1];
        let dx = 0.6 * (along - 0.2 - 0.6 * random[0]) / PLANK_WIDTH;
        let dy = across - center;
        let distance = dx.hypot(dy).max(1e-4);
        // Stream function of a flow around a cylinder, which is zero on its outline.
        let outside = (1.0 - (RADIUS / distance).powi(2)).max(0.0);
        Self {
            across: center + dy * outside,
            rings: 5.0 * (1.0 - distance / RADIUS).max(0.0),
            dark: smoothstep(1.5 * RADIUS, 0.5 * RADIUS, distance),
        }
    }
}

/// Coverage of a nail's head and of the dent around it, each 0 to 1.
struct Nail {
    head: f32,
    rim: f32,
}

/// Two nails hold each end of a plank; distances to its end and to its side are in units.
fn nail(end: f32, side: f32) -> Nail {
    let distance = (end - 0.022).hypot(side - 0.04);
    let head = smoothstep(0.0062, 0.0046, distance);
    Nail {
        head,
        rim: smoothstep(0.0105, 0.0065, distance) * (1.0 - head),
    }
}

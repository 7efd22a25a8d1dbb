//! A thicket of leaves with gaps.

use crate::content::{
    lattice::{Noise, neighbours, smoothstep},
    material::{Border, Material, Sample, render, units},
    texture::{Color, hex, mix, ramp, shade},
};

/// Leaves per unit of each layer, the deepest first: many small ones in the shade below few large.
const LAYERS: [i32; 4] = [9, 7, 6, 5];

const GREENS: [Color; 4] = [hex(0x24451B), hex(0x3D6B26), hex(0x5F8F34), hex(0x93B24C)];
const AUTUMN: [Color; 3] = [hex(0x7A4A1E), hex(0xB5762A), hex(0xC9A63E)];
/// Behind the leaves: a dark green, so that filtering across the mask does not fringe.
const SHADE: Color = hex(0x16230F);

/// Leaves in layers, with veins, curl, insect holes and a few that autumn has reached. Tiles; the
/// mask is the opacity.
pub fn foliage(width: u32, height: u32, seed: u64) -> Material {
    let noise = Noise::new(seed, units(width, height));
    render(width, height, Border::Wrap, |point| sample(noise, point))
}

fn sample(noise: Noise, point: [f32; 2]) -> Sample {
    let mut top = Sample {
        color: SHADE,
        height: 0.0,
        mask: 0.0,
    };
    for (layer, frequency) in LAYERS.into_iter().enumerate() {
        let noise = noise.stream(layer as u32 + 1);
        let depth = (layer + 1) as f32 / LAYERS.len() as f32;
        let [x, y] = point.map(|axis| axis * frequency as f32);
        let ripple = noise.stream(30).fractal(point, [30, 30], 3);
        for (dx, dy) in neighbours(1) {
            let cell = [x.floor() as i32 + dx, y.floor() as i32 + dy];
            let [id_x, id_y] = noise.wrap(cell, [frequency; 2]);
            let random = |i: u32| noise.stream(10 + i).uniform(id_x, id_y);
            if random(0) < 0.5 {
                continue;
            }
            let angle = random(1) * std::f32::consts::TAU;
            let (sin, cos) = angle.sin_cos();
            let offset_x = x - (cell[0] as f32 + 0.2 + 0.6 * random(2));
            let offset_y = y - (cell[1] as f32 + 0.2 + 0.6 * random(3));
            let size = 0.72 + 0.22 * random(4);
            let leaf = Leaf {
                s: (offset_x * cos + offset_y * sin) / size,
                t: (offset_y * cos - offset_x * sin) / size,
                bend: 0.3 * (random(5) - 0.5),
                ripple,
            };
            leaf.cover(&mut top, depth, [random(6), random(7), random(8)]);
        }
    }
    top
}

/// A point as one leaf sees it.
struct Leaf {
    /// Position along the midrib: -1 at the stem, 1 at the tip.
    s: f32,
    /// Position across, same scale.
    t: f32,
    /// Curvature of the midrib.
    bend: f32,
    /// Irregularity, about -1 to 1.
    ripple: f32,
}

impl Leaf {
    /// Lays the leaf over `top`, or its shadow where it only passes close by.
    fn cover(&self, top: &mut Sample, depth: f32, random: [f32; 3]) {
        let Self { s, ripple, .. } = *self;
        if s.abs() > 1.3 {
            return;
        }
        let t = self.t - self.bend * (1.0 - s * s);
        // Teeth point to the tip, the outline narrows faster towards it.
        let tooth = (s * 11.0).rem_euclid(1.0) * 0.035;
        let blade = if s.abs() < 1.0 {
            (1.0 - s * s).powf(0.75) * (0.46 - 0.16 * s) - tooth * (1.0 - s * s)
        } else {
            0.0
        };
        let stem = if s < -0.9 {
            0.022 * smoothstep(-1.3, -1.2, s)
        } else {
            0.0
        };
        let inside = blade.max(stem) - t.abs() + 0.02 * ripple;
        if inside < -0.16 {
            return;
        }
        // Fades out past the ends, where the outline stops.
        let shadow = smoothstep(-0.16, 0.0, inside) * smoothstep(1.25, 1.0, s.abs());
        top.color = shade(top.color, 1.0 - 0.55 * shadow);

        let eaten =
            smoothstep(0.62, 0.68, ripple + 0.25 * random[2]) * smoothstep(0.03, 0.08, inside);
        let cover = smoothstep(0.0, 0.02, inside) * (1.0 - eaten);
        if cover == 0.0 {
            return;
        }

        let midrib = smoothstep(0.028 - 0.012 * s, 0.008, t.abs());
        // Side veins leave the midrib at an angle and curve towards the tip.
        let vein_phase = ((s - 0.75 * t.abs() + 0.35 * t * t) * 5.5).rem_euclid(1.0);
        let from_vein = (vein_phase - 0.5).abs();
        let vein = smoothstep(0.07, 0.015, from_vein) * smoothstep(0.0, 0.06, inside);
        let net = smoothstep(
            0.25,
            0.05,
            (self.s * 43.0)
                .sin()
                .abs()
                .min((t * 47.0 + s * 9.0).sin().abs()),
        );

        let age = random[0];
        let tone = 0.15
            + 0.35 * depth
            + 0.4 * (random[1] - 0.5)
            + 0.12 * ripple
            + 0.10 * (0.5 - from_vein)
            + 0.12 * t.signum() * smoothstep(0.0, 0.1, t.abs());
        let mut color = ramp(&GREENS, tone);
        let spot = smoothstep(0.1, 0.0, inside) * 0.6 + smoothstep(0.25, 0.55, ripple);
        if age > 0.86 {
            color = mix(color, ramp(&AUTUMN, tone + 0.2), 0.85);
        } else {
            color = mix(
                color,
                ramp(&AUTUMN, 0.4 + ripple),
                0.7 * spot * smoothstep(0.35, 0.9, age),
            );
        }
        color = mix(color, shade(color, 0.82), 0.5 * net * (1.0 - vein));
        color = mix(color, GREENS[3], 0.45 * vein);
        color = mix(color, mix(GREENS[3], hex(0xE2E3B0), 0.5), 0.75 * midrib);
        color = shade(
            color,
            (0.45 + 0.6 * depth) * (1.0 - 0.2 * smoothstep(0.25, 0.5, from_vein)),
        );

        let dome = 0.02 * (inside.max(0.0) * 3.0).min(1.0).sqrt();
        let height = 0.03 * depth + dome + 0.004 * (0.5 - from_vein) - 0.004 * midrib
            + 0.0012 * ripple
            + 0.010 * self.bend * s;
        *top = Sample {
            color: mix(top.color, color, cover),
            height: top.height + (height - top.height) * cover,
            mask: top.mask.max(cover),
        };
    }
}

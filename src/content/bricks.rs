//! A weathered brick wall.

use crate::content::{
    lattice::{Noise, smoothstep},
    material::{Border, Material, Sample, render, units},
    texture::{Color, hex, mix, ramp, shade},
};

/// Bricks per unit, along and up the wall. Rows are even in number, as the running bond repeats
/// with every second one.
const BRICKS_PER_UNIT: [i32; 2] = [3, 8];
/// Size of a brick and its joint in units.
const BRICK_SIZE: [f32; 2] = [
    1.0 / BRICKS_PER_UNIT[0] as f32,
    1.0 / BRICKS_PER_UNIT[1] as f32,
];

const CLAY: [Color; 5] = [
    hex(0x4A2C27),
    hex(0x7A4034),
    hex(0x96503D),
    hex(0xA5664C),
    hex(0xB98B6C),
];
const MORTAR: [Color; 3] = [hex(0x7D7568), hex(0x9D9484), hex(0xBDB5A4)];
const SOOT: Color = hex(0x2B2724);
const SALT: Color = hex(0xD8CFC2);
const MOSS: Color = hex(0x56602F);

/// A wall of bricks in running bond: chipped, each fired differently, with sandy mortar, soot,
/// salt and moss. Tiles; the mask is the bricks, without their joints.
pub fn bricks(width: u32, height: u32, seed: u64) -> Material {
    let noise = Noise::new(seed, units(width, height));
    render(width, height, Border::Wrap, |point| sample(noise, point))
}

fn sample(noise: Noise, point: [f32; 2]) -> Sample {
    let brick = Brick::at(noise, point);
    let grit = noise.stream(1).fractal(point, [80, 80], 3);
    let grain = noise.stream(10).gradient(point, [260, 260]);
    let wear = noise.stream(2).fractal(point, [3, 3], 5);

    // Rough outline: slow waviness, fine crumbs and the odd chip bitten out of the edge.
    let crumble = noise.stream(3).fractal(point, [14, 14], 4) * 0.006;
    let chip = smoothstep(0.35, 0.75, noise.stream(4).fractal(point, [9, 9], 3)) * 0.022;
    let depth = brick.inside + crumble - chip;
    let cover = smoothstep(0.0, 0.005, depth);
    let holes = noise.stream(5).fractal(point, [38, 46], 3);
    let pit = smoothstep(
        0.42,
        0.62,
        holes + 0.25 * noise.stream(6).gradient(point, [7, 9]),
    );

    let fired = 0.5
        + 0.32 * (brick.random[0] * 2.0 - 1.0)
        + 0.22 * noise.stream(7).fractal(point, [10, 22], 5)
        + 0.22 * grit;
    let mut clay = shade(ramp(&CLAY, fired), 0.9 + 0.2 * brick.random[1]);
    clay = mix(clay, shade(clay, 0.45), pit * 0.8);
    // Edges are worn paler than faces.
    clay = mix(clay, CLAY[4], 0.35 * smoothstep(0.016, 0.004, depth));
    if brick.random[2] < 0.12 {
        clay = mix(clay, SOOT, 0.45 + 0.2 * wear);
    }

    let sand = noise.stream(8).fractal(point, [70, 70], 3);
    let mut joint = ramp(&MORTAR, 0.5 + 0.9 * sand + 0.3 * wear);
    // The joint lies deep and gets less light near the brick.
    joint = shade(joint, 0.72 + 0.28 * smoothstep(0.002, -0.005, depth));

    let mut color = mix(joint, clay, cover);
    color = mix(
        color,
        SALT,
        0.55 * smoothstep(0.25, 0.8, wear + 0.35 * grit) * cover,
    );
    let damp = noise.stream(9).fractal(point, [2, 2], 6);
    color = mix(color, SOOT, 0.5 * smoothstep(0.1, 0.8, damp));
    let moss = smoothstep(0.15, 0.55, -damp + 0.3 * sand - 0.25 * cover);
    color = mix(color, shade(MOSS, 1.0 + 0.5 * grit), 0.7 * moss);

    color = shade(color, 1.0 + 0.22 * grain);

    let face = 0.016 + 0.004 * smoothstep(0.0, 0.02, depth) + 0.0012 * grit + 0.0003 * grain
        - 0.006 * pit
        + (brick.random[3] - 0.5) * 0.004;
    let bed = 0.0022 * sand + 0.003 * moss;
    Sample {
        color,
        height: bed + (face - bed) * smoothstep(-0.001, 0.009, depth),
        mask: cover,
    }
}

/// The brick nearest to a point.
struct Brick {
    /// Distance to the outline in units, positive inside.
    inside: f32,
    /// Its own random numbers, 0 to 1.
    random: [f32; 4],
}

impl Brick {
    fn at(noise: Noise, [x, y]: [f32; 2]) -> Self {
        // The border of the tile runs through bricks rather than along a joint, which would show
        // how few the rows are.
        let [x, y] = [x + 0.25 * BRICK_SIZE[0], y + 0.5 * BRICK_SIZE[1]];
        let row = (y / BRICK_SIZE[1]).floor() as i32;
        let along = x / BRICK_SIZE[0] - 0.5 * (row & 1) as f32;
        let [column, row_id] = noise.wrap([along.floor() as i32, row], BRICKS_PER_UNIT);
        let random = std::array::from_fn(|i| noise.stream(20 + i as u32).uniform(column, row_id));

        // From the centre, after a slight turn and shift: bricks are laid by hand.
        let jitter = |i| noise.stream(i).uniform(column, row_id) - 0.5;
        let dx = (along - along.floor() - 0.5) * BRICK_SIZE[0] + 0.008 * jitter(30);
        let dy = (y / BRICK_SIZE[1] - row as f32 - 0.5) * BRICK_SIZE[1] + 0.006 * jitter(31);
        let turn = 0.03 * jitter(32);
        let (dx, dy) = (dx + turn * dy, dy - turn * dx);

        // Signed distance to a box with rounded corners.
        const CORNER: f32 = 0.012;
        const JOINT: f32 = 0.0085;
        let beyond_x = dx.abs() - (BRICK_SIZE[0] / 2.0 - JOINT - CORNER);
        let beyond_y = dy.abs() - (BRICK_SIZE[1] / 2.0 - JOINT - CORNER);
        let outside = beyond_x.max(0.0).hypot(beyond_y.max(0.0));
        Self {
            inside: CORNER - outside - beyond_x.max(beyond_y).min(0.0),
            random,
        }
    }
}

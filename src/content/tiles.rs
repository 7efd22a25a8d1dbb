//! Surfaces that tile: a brick wall, a floor of planks, a thicket of leaves, painted signs, fractal rock, and packed maps.

use crate::content::surface::{
    Color, Material, Noise, Sample, hex, mix, neighbours, ramp, render_tile, shade, smoothstep,
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
    render_tile(width, height, seed, brick_sample)
}

fn brick_sample(noise: Noise, point: [f32; 2]) -> Sample {
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

/// Planks across a unit, and planks end to end along one.
const PLANKS_PER_UNIT: [i32; 2] = [1, 5];
/// Width of a plank in units.
const PLANK_WIDTH: f32 = 1.0 / PLANKS_PER_UNIT[1] as f32;

const HEARTWOOD: [Color; 4] = [hex(0x4E2F1A), hex(0x7D512D), hex(0xA6743F), hex(0xC79A62)];
const GAP: Color = hex(0x17100B);

/// Planks with annual rings, pores, knots, nails and wear, running along x. Tiles; the mask is the
/// planks, without the gaps between them.
pub fn wood(width: u32, height: u32, seed: u64) -> Material {
    render_tile(width, height, seed, wood_sample)
}

fn wood_sample(noise: Noise, [x, y]: [f32; 2]) -> Sample {
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

/// Leaves per unit of each layer, the deepest first: many small ones in the shade below few large.
const LAYERS: [i32; 4] = [9, 7, 6, 5];

const GREENS: [Color; 4] = [hex(0x24451B), hex(0x3D6B26), hex(0x5F8F34), hex(0x93B24C)];
const AUTUMN: [Color; 3] = [hex(0x7A4A1E), hex(0xB5762A), hex(0xC9A63E)];
/// Behind the leaves: a dark green, so that filtering across the mask does not fringe.
const SHADE: Color = hex(0x16230F);

/// Leaves in layers, with veins, curl, insect holes and a few that autumn has reached. Tiles; the
/// mask is the opacity.
pub fn foliage(width: u32, height: u32, seed: u64) -> Material {
    render_tile(width, height, seed, foliage_sample)
}

fn foliage_sample(noise: Noise, point: [f32; 2]) -> Sample {
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
    render_tile(width, height, seed, decal_sample)
}

fn decal_sample(noise: Noise, point: [f32; 2]) -> Sample {
    // No edge between panels lies on the border of the image.
    let scaled = point.map(|p| p * CELLS as f32 + 0.25);
    let cell = noise.wrap(scaled.map(|p| p.floor() as i32), [CELLS; 2]);
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
    render_tile(width, height, seed, noise_sample)
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

/// Occlusion in R (smooth), roughness in G (scratches and stains of all scales), metallic in B (sharp
/// regions of all or nothing), as glTF packs them. Tiles; the mask is the metal.
pub fn packed_maps(width: u32, height: u32, seed: u64) -> Material {
    render_tile(width, height, seed, packed_sample)
}

fn packed_sample(noise: Noise, point: [f32; 2]) -> Sample {
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

//! A stand-in for a photograph: a landscape with the statistics of one.

use image::RgbImage;

use crate::content::surface::{
    Border, Color, Noise, Sample, byte, hex, lerp, mix, neighbours, ramp, render, shade,
    smoothstep, units,
};

/// A landscape as a camera would take it: a smooth sky with clouds, hazy mountains, woods, a lake
/// with reflections, painted houses, a meadow in bloom, and balloons. It offers a codec what
/// photographs do: slow gradients, texture at many scales, sharp edges, saturated colours, and
/// sensor noise. 768x512 is the size of the Kodak images, which it can replace in examples.
pub fn photo_like(width: u32, height: u32, seed: u64) -> RgbImage {
    // Large enough never to be seen repeating.
    let noise = Noise::new(seed, [1 << 8; 2]);
    let scene = Scene {
        noise,
        aspect: width as f32 / height.max(1) as f32,
    };
    let unit = units(width, height).map(|units| units as f32);
    let mut photo = render(width, height, Border::Clamp, |[x, y]| Sample {
        color: scene.color([x / unit[0] * scene.aspect, y / unit[1]]),
        ..Sample::default()
    })
    .color;

    let sensor = noise.stream(1);
    for (x, y, pixel) in photo.enumerate_pixels_mut() {
        let noise = |stream| sensor.stream(stream).uniform(x as i32, y as i32) - 0.5;
        // The sum of two uniform deviates is bell-shaped enough; chroma is noisy, too, but less.
        let luma = noise(0) + noise(1);
        for (channel, value) in pixel.0.iter_mut().enumerate() {
            let grain = luma + 0.5 * noise(2 + channel as u32);
            *value = byte(f32::from(*value) / 255.0 + 0.012 * grain);
        }
    }
    photo
}

/// The scene, seen at points of which y runs from 0 (top) to 1 and x from 0 to `aspect`.
struct Scene {
    noise: Noise,
    aspect: f32,
}

impl Scene {
    fn color(&self, point: [f32; 2]) -> Color {
        let color = if point[1] > SHORE {
            meadow(self.noise, point)
        } else if point[1] > HORIZON {
            self.lake(point)
        } else {
            self.above_horizon(point)
        };
        let color = houses(self.noise.stream(5), point, SHORE).unwrap_or(color);
        let corner = (point[0] / self.aspect - 0.5).hypot(point[1] - 0.5);
        shade(color, 1.04 - 0.3 * corner * corner)
    }

    fn above_horizon(&self, point: [f32; 2]) -> Color {
        balloons(self.noise.stream(4), point, self.aspect)
            .or_else(|| {
                let noise = self.noise.stream(3);
                woods(noise, point).or_else(|| mountains(noise, point))
            })
            .unwrap_or_else(|| self.sky(point))
    }

    fn sky(&self, [x, y]: [f32; 2]) -> Color {
        let noise = self.noise.stream(2);
        let clear = mix(hex(0x2F6DB5), HAZE, smoothstep(-0.1, HORIZON, y));
        // Clouds flatten towards the horizon.
        let distance = 0.25 / (HORIZON + 0.08 - y);
        let cloud_point = [x * distance + 3.0, 2.2 * distance];
        let density = noise.fractal(cloud_point, [2, 3], 6) + 0.12;
        let lit = noise.fractal([cloud_point[0] - 0.05, cloud_point[1] - 0.06], [2, 3], 6) + 0.12;
        let cloud = mix(hex(0xFBF7EF), hex(0x98A2B3), smoothstep(-0.2, 0.35, lit));
        mix(clear, cloud, 0.92 * smoothstep(0.0, 0.32, density))
    }

    /// The scene above, mirrored in ripples that look finer the farther they are.
    fn lake(&self, [x, y]: [f32; 2]) -> Color {
        let noise = self.noise.stream(6);
        let near = (y - HORIZON) / (SHORE - HORIZON);
        let distance = 0.1 / (y - HORIZON + 0.02);
        let ripple = noise.fractal([x * distance * 2.0, distance * 6.0], [5, 12], 4);
        let mirrored = [
            x + 0.010 * ripple * near,
            HORIZON - 1.15 * (y - HORIZON) + 0.035 * ripple * near,
        ];
        let reflection = self.above_horizon([mirrored[0], mirrored[1].min(HORIZON)]);
        let water = mix(hex(0x1D4A5A), hex(0x2F6672), near);
        let color = mix(reflection, water, 0.25 + 0.3 * near);
        let glint = smoothstep(0.45, 0.8, ripple) * 0.45;
        mix(shade(color, 0.95 + 0.15 * ripple), hex(0xEAF3F5), glint)
    }
}

/// Horizon of the picture, as a fraction of its height from the top.
const HORIZON: f32 = 0.56;
/// Near shore of the lake.
const SHORE: f32 = 0.70;
/// Colour of distant air.
const HAZE: Color = hex(0xC3D3E0);

const ROCK: [Color; 3] = [hex(0x4B5058), hex(0x7A7B7C), hex(0xA39C90)];
const SNOW: Color = hex(0xF2F5FA);
const WOOD: [Color; 4] = [hex(0x15291A), hex(0x254427), hex(0x3F6432), hex(0x75863F)];
const GRASS: [Color; 4] = [hex(0x23380F), hex(0x456321), hex(0x7A9138), hex(0xB9B865)];
const PETALS: [Color; 4] = [hex(0xD8172B), hex(0xF6C913), hex(0xF5F0F2), hex(0x7E3BB8)];

/// The mountains above the horizon, where they cover a point.
fn mountains(noise: Noise, [x, y]: [f32; 2]) -> Option<Color> {
    let noise = noise.stream(1);
    let peaks = 0.5 - noise.fractal([x, 0.5], [3, 1], 7).abs();
    let crest =
        HORIZON - 0.02 - 0.5 * peaks * (0.75 + 0.4 * noise.stream(1).gradient([x, 0.0], [2, 1]));
    if y < crest {
        return None;
    }
    // Folds run down the slope; the sun stands on the left.
    let below = y - crest;
    let fold = |x: f32| {
        noise
            .stream(2)
            .fractal([x + 0.6 * below, 0.7 * y], [7, 6], 6)
    };
    let relief = fold(x);
    let light = 0.5 + 6.0 * (fold(x + 0.006) - relief) + 0.3 * relief;
    let rock = ramp(&ROCK, light);
    let snow = smoothstep(0.04, -0.06, below - 0.05 + 0.3 * relief);
    let color = mix(rock, shade(SNOW, 0.72 + 0.28 * light.clamp(0.0, 1.0)), snow);
    Some(mix(color, HAZE, 0.38 + 0.35 * smoothstep(0.0, 0.25, below)))
}

/// The same of the nearer hills with their woods.
fn woods(noise: Noise, [x, y]: [f32; 2]) -> Option<Color> {
    let noise = noise.stream(5);
    let hill = HORIZON - 0.05 - 0.07 * noise.gradient([x, 0.5], [2, 1]);
    // Tree tops: spikes of individual heights on the hill line.
    let trunk = x * 95.0;
    let tall = noise.stream(1).uniform(trunk.floor() as i32, 0);
    let top = 1.0 - ((trunk - trunk.floor()) - 0.5).abs() * 2.0;
    let crest = hill - 0.018 * tall * top - 0.004 * noise.stream(2).fractal([x, y], [60, 60], 3);
    if y < crest {
        return None;
    }
    let crowns = noise.stream(3).cellular([x, y * 1.6], [48, 48]);
    let leaves = noise.stream(4).fractal([x, y], [70, 90], 4);
    let stand = noise.stream(6).fractal([x, y], [5, 9], 4);
    let tone = 0.75 - 0.75 * crowns + 0.3 * leaves + 0.25 * stand;
    let shore = smoothstep(0.02, 0.0, HORIZON - y);
    Some(mix(shade(ramp(&WOOD, tone), 1.0 - 0.6 * shore), HAZE, 0.16))
}

/// The meadow below the near shore, in perspective: blades of grass and flowers.
fn meadow(noise: Noise, [x, y]: [f32; 2]) -> Color {
    let noise = noise.stream(20);
    // Ground plane: distance from the camera falls from the shore to the lower edge.
    let distance = 0.22 / (y - SHORE + 0.10);
    let ground = [(x - 0.75) * distance + 4.0, 1.5 * distance + 1.0];
    let patch = noise.fractal(ground, [2, 2], 4);
    // Blades stand upright, hence streaks in picture space, longer and wider near the camera.
    let near = smoothstep(0.0, 0.28, y - SHORE);
    let sway = 0.012 * near * noise.stream(1).gradient([x, y], [22, 14]);
    let upright = [x + sway, y];
    let short = noise.stream(2).fractal(upright, [150, 60], 3);
    let long = noise.stream(3).fractal(upright, [64, 11], 4);
    let blades = lerp(short, long, near);
    let tone = 0.5 + 0.62 * blades + 0.3 * patch - 0.12 * near;
    let mut color = ramp(&GRASS, tone);

    // Flowers in drifts, of the kind that prevails there.
    for (stream, frequency) in [(30, 16), (31, 11)] {
        let bloom = noise.stream(stream);
        let [gx, gy] = ground.map(|axis| axis * frequency as f32);
        for (dx, dy) in neighbours(1) {
            let cell = [gx.floor() as i32 + dx, gy.floor() as i32 + dy];
            let random = |i: u32| bloom.stream(i).uniform(cell[0], cell[1]);
            let drift = bloom.stream(9).gradient(
                [
                    cell[0] as f32 / frequency as f32,
                    cell[1] as f32 / frequency as f32,
                ],
                [2, 2],
            );
            if random(1) > 0.35 + 0.8 * drift {
                continue;
            }
            let across = gx - (cell[0] as f32 + random(2));
            let along = (gy - (cell[1] as f32 + random(3))) * 0.8;
            let petal = 1.0 + 0.22 * (along.atan2(across) * 5.0).cos();
            let radius = across.hypot(along) / (0.20 + 0.14 * random(4)) / petal;
            let kind = PETALS[((random(5) * 1.6 + 1.2 + 1.6 * drift) as usize) % PETALS.len()];
            let shaded = shade(
                kind,
                0.7 + 0.3 * smoothstep(0.2, 1.0, radius) + 0.25 * across,
            );
            let head = mix(shaded, hex(0x5A3A10), smoothstep(0.34, 0.24, radius));
            color = mix(color, head, smoothstep(1.0, 0.88, radius));
        }
    }
    shade(color, 0.72 + 0.4 * smoothstep(-0.6, 0.4, patch))
}

const PAINTS: [Color; 6] = [
    hex(0xC22A2E),
    hex(0xE9B52C),
    hex(0x2567A8),
    hex(0x3A8F5B),
    hex(0xE8E2D4),
    hex(0xD96C2B),
];

/// The hot-air balloon that covers a point of the sky, if one does.
fn balloons(noise: Noise, point: [f32; 2], aspect: f32) -> Option<Color> {
    (0..4).find_map(|i| {
        let random = |stream: u32| noise.stream(stream).uniform(i, 0);
        // Each in its own quarter of the width, the nearest first.
        let column = (i * 3 + 2) % 4;
        let radius = 0.105 - 0.022 * i as f32;
        let center = [
            aspect * (column as f32 + 0.3 + 0.4 * random(0)) / 4.0,
            0.13 + 0.16 * random(1) + 0.02 * i as f32,
        ];
        balloon(
            [
                (point[0] - center[0]) / radius,
                (point[1] - center[1]) / radius,
            ],
            [random(2), random(3)],
        )
    })
}

/// A balloon of radius 1 around the origin.
fn balloon([x, y]: [f32; 2], random: [f32; 2]) -> Option<Color> {
    // The envelope narrows to its mouth below.
    let half_width = if y < 0.25 {
        (1.0 - y * y).max(0.0).sqrt()
    } else {
        0.968 * (1.0 - smoothstep(0.25, 1.9, y)).max(0.0).powf(1.25)
    };
    let basket = (1.62..1.85).contains(&y) && x.abs() < 0.15;
    let rope = (1.3..1.62).contains(&y) && (x.abs() - 0.14).abs() < 0.012;
    if basket {
        let weave = ((y * 60.0).sin() * (x * 70.0).sin()).signum();
        return Some(shade(hex(0x7A4E28), 0.9 + 0.15 * weave - 0.6 * x));
    }
    if rope {
        return Some(hex(0x3B3129));
    }
    if y > 1.4 || x.abs() >= half_width {
        return None;
    }
    let turn = (x / half_width).asin();
    let gore = (turn / std::f32::consts::PI * 10.0 + 10.0 * random[0]).floor();
    let first = PAINTS[(random[0] * 6.0) as usize % 6];
    let second = PAINTS[((random[0] * 6.0) as usize + 1 + (random[1] * 4.0) as usize) % 6];
    let paint = match gore.rem_euclid(2.0) as i32 {
        _ if (-0.05..0.25).contains(&(y + 0.12 * (turn * 10.0).sin())) => PAINTS[4],
        0 => first,
        _ => second,
    };
    let normal = [turn.sin(), y.clamp(-1.0, 1.0)];
    let depth = (1.0 - normal[0] * normal[0] * 0.9 - normal[1] * normal[1] * 0.5)
        .max(0.0)
        .sqrt();
    let light = (-0.55 * normal[0] - 0.5 * normal[1] + 0.67 * depth).max(0.0);
    Some(mix(
        shade(paint, 0.32 + 0.75 * light),
        [1.0; 3],
        0.25 * smoothstep(0.9, 1.0, light),
    ))
}

/// The house that covers a point, if one does; they stand on the `shore`.
fn houses(noise: Noise, [x, y]: [f32; 2], shore: f32) -> Option<Color> {
    const PITCH: f32 = 0.115;
    let cell = (x / PITCH).floor();
    let random = |stream: u32| noise.stream(stream).uniform(cell as i32, 0);
    if random(0) < 0.4 {
        return None;
    }
    let width = PITCH * (0.62 + 0.3 * random(1));
    let left = cell * PITCH + (PITCH - width) * random(2);
    let base = shore + 0.012 + 0.012 * random(3);
    let wall = 0.06 + 0.045 * random(4);
    let (s, t) = ((x - left) / width, (base - y) / wall);
    let texture = noise.stream(10).fractal([x, y], [50, 90], 4);

    // A gable roof over the wall, overhanging a little.
    let overhang = 0.06;
    let rise = (t - 1.0) * wall / (0.55 * width);
    let roof_edge = 1.0 - (s - 0.5).abs() / (0.5 + overhang);
    if t > 1.0 && rise < roof_edge {
        let tile = ((rise * 9.0).rem_euclid(1.0) - 0.5).abs() + 0.5 * texture;
        let fascia = smoothstep(0.10, 0.06, roof_edge - rise);
        let roof = mix(
            hex(0x7C3B2A),
            hex(0x46403F),
            smoothstep(0.45, 0.55, random(5)),
        );
        return Some(mix(shade(roof, 0.75 + 0.6 * tile), hex(0xE9E4DA), fascia));
    }
    if !(0.0..=1.0).contains(&s) || !(0.0..=1.0).contains(&t) {
        return None;
    }
    let paint = PAINTS[(random(6) * 6.0) as usize % 6];
    let board = ((t * wall * 170.0).rem_euclid(1.0) - 0.5).abs();
    let facade = shade(
        paint,
        0.82 + 0.14 * board + 0.1 * texture - 0.25 * smoothstep(0.9, 1.0, t),
    );
    let columns = if width > 0.085 { 4.0 } else { 3.0 };
    let (pane_s, pane_t) = ((s * columns).fract() - 0.5, (t * 2.0).fract() - 0.55);
    let frame = pane_s.abs().max(pane_t.abs() * 0.85);
    if frame > 0.29 {
        return Some(facade);
    }
    let mullion = pane_s.abs() < 0.035 || pane_t.abs() < 0.035;
    let glass = mix(
        hex(0x1C2A38),
        hex(0x9DB6C9),
        smoothstep(-0.3, 0.4, pane_t + pane_s + texture),
    );
    Some(if frame > 0.235 || mullion {
        hex(0xF3EFE6)
    } else {
        glass
    })
}

//! Mountains, woods and meadow.

use super::super::color::{Color, hex, mix, ramp, shade};
use super::super::lattice::{Noise, lerp, neighbours, smoothstep};

/// Horizon of the picture, as a fraction of its height from the top.
pub(super) const HORIZON: f32 = 0.56;
/// Near shore of the lake.
pub(super) const SHORE: f32 = 0.70;
/// Colour of distant air.
pub(super) const HAZE: Color = hex(0xC3D3E0);

const ROCK: [Color; 3] = [hex(0x4B5058), hex(0x7A7B7C), hex(0xA39C90)];
const SNOW: Color = hex(0xF2F5FA);
const WOOD: [Color; 4] = [hex(0x15291A), hex(0x254427), hex(0x3F6432), hex(0x75863F)];
const GRASS: [Color; 4] = [hex(0x23380F), hex(0x456321), hex(0x7A9138), hex(0xB9B865)];
const PETALS: [Color; 4] = [hex(0xD8172B), hex(0xF6C913), hex(0xF5F0F2), hex(0x7E3BB8)];

/// What rises above the horizon.
pub(super) struct Landscape {
    pub noise: Noise,
}

impl Landscape {
    /// The nearest ridge that covers a point, if any does.
    pub fn ridges(&self, point: [f32; 2]) -> Option<Color> {
        self.woods(point).or_else(|| self.mountains(point))
    }

    fn mountains(&self, [x, y]: [f32; 2]) -> Option<Color> {
        let noise = self.noise.stream(1);
        let peaks = 0.5 - noise.fractal([x, 0.5], [3, 1], 7).abs();
        let crest = HORIZON
            - 0.02
            - 0.5 * peaks * (0.75 + 0.4 * noise.stream(1).gradient([x, 0.0], [2, 1]));
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

    fn woods(&self, [x, y]: [f32; 2]) -> Option<Color> {
        let noise = self.noise.stream(5);
        let hill = HORIZON - 0.05 - 0.07 * noise.gradient([x, 0.5], [2, 1]);
        // Tree tops: spikes of individual heights on the hill line.
        let trunk = x * 95.0;
        let tall = noise.stream(1).uniform(trunk.floor() as i32, 0);
        let top = 1.0 - ((trunk - trunk.floor()) - 0.5).abs() * 2.0;
        let crest =
            hill - 0.018 * tall * top - 0.004 * noise.stream(2).fractal([x, y], [60, 60], 3);
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
}

/// The meadow below the near shore, in perspective: blades of grass and flowers.
pub(super) fn meadow(noise: Noise, [x, y]: [f32; 2]) -> Color {
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

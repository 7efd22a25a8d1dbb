//! Seeded noise that repeats with its tile: the raw material of every texture here.
//!
//! Gradient noise after K. Perlin, "Improving Noise", SIGGRAPH 2002, on a lattice that wraps; its
//! own few lines rather than a crate, because all that is needed is this wrapping.

/// Noise over a tile of whole units, repeating with it.
#[derive(Clone, Copy)]
pub(super) struct Noise {
    seed: u32,
    /// Size of the tile in units, along each axis.
    units: [i32; 2],
}

impl Noise {
    pub fn new(seed: u64, units: [i32; 2]) -> Self {
        Self {
            seed: mix_bits(seed as u32 ^ mix_bits((seed >> 32) as u32)),
            units,
        }
    }

    /// Another noise of the same tile, independent of this one for every other `stream`.
    pub fn stream(self, stream: u32) -> Self {
        Self {
            seed: mix_bits(self.seed ^ stream.wrapping_mul(0x9E37_79B1)),
            ..self
        }
    }

    /// Uniformly distributed in 0 to 1, for an integer cell; does not wrap.
    pub fn uniform(self, x: i32, y: i32) -> f32 {
        (self.hash(x, y) >> 8) as f32 / (1u32 << 24) as f32
    }

    /// Gradient noise, about -1 to 1, with `frequency` lattice cells per unit.
    pub fn gradient(self, [x, y]: [f32; 2], frequency: [i32; 2]) -> f32 {
        let [x, y] = [x * frequency[0] as f32, y * frequency[1] as f32];
        let cell = [floor(x), floor(y)];
        let [fx, fy] = [x - cell[0] as f32, y - cell[1] as f32];
        let low = self.wrap(cell, frequency);
        let high = self.wrap([cell[0] + 1, cell[1] + 1], frequency);
        let columns = [low[0], high[0]].map(|x| mix_bits(self.seed ^ x as u32));
        let corner = |dx: usize, dy: usize| {
            let row = [low[1], high[1]][dy] as u32;
            let bits = mix_bits(columns[dx].wrapping_add(row));
            let gradient = |bits: u32| (bits & 0xFFFF) as f32 / 32767.5 - 1.0;
            gradient(bits) * (fx - dx as f32) + gradient(bits >> 16) * (fy - dy as f32)
        };
        let [sx, sy] = [fade(fx), fade(fy)];
        let near = lerp(corner(0, 0), corner(1, 0), sx);
        let far = lerp(corner(0, 1), corner(1, 1), sx);
        lerp(near, far, sy) * 1.4
    }

    /// Fractal sum of `octaves` of [`Self::gradient`], each twice as fine and half as strong as the
    /// one before; about -1 to 1.
    pub fn fractal(self, point: [f32; 2], frequency: [i32; 2], octaves: u32) -> f32 {
        let total = 2.0 - 0.5f32.powi(octaves as i32 - 1);
        let sum: f32 = (0..octaves)
            .map(|octave| {
                let frequency = frequency.map(|f| f << octave);
                self.stream(octave).gradient(point, frequency) * 0.5f32.powi(octave as i32)
            })
            .sum();
        sum / total * 1.5
    }

    /// Distance to the nearest of points scattered one per lattice cell, in cells (0 to about 1).
    pub fn cellular(self, [x, y]: [f32; 2], frequency: [i32; 2]) -> f32 {
        let [x, y] = [x * frequency[0] as f32, y * frequency[1] as f32];
        let [cell_x, cell_y] = [x.floor() as i32, y.floor() as i32];
        let mut nearest = f32::MAX;
        for (dx, dy) in neighbours(1) {
            let [hx, hy] = self.wrap([cell_x + dx, cell_y + dy], frequency);
            let point_x = (cell_x + dx) as f32 + self.uniform(hx, hy);
            let point_y = (cell_y + dy) as f32 + self.stream(1).uniform(hx, hy);
            nearest = nearest.min((x - point_x).hypot(y - point_y));
        }
        nearest
    }

    /// The cell of the tile that a lattice cell repeats.
    pub fn wrap(self, [x, y]: [i32; 2], frequency: [i32; 2]) -> [i32; 2] {
        [
            x.rem_euclid(frequency[0] * self.units[0]),
            y.rem_euclid(frequency[1] * self.units[1]),
        ]
    }

    fn hash(self, x: i32, y: i32) -> u32 {
        mix_bits(mix_bits(self.seed ^ x as u32).wrapping_add(y as u32))
    }
}

/// Offsets of the cells within `radius` of a cell, itself included.
pub(super) fn neighbours(radius: i32) -> impl Iterator<Item = (i32, i32)> {
    (-radius..=radius).flat_map(move |dy| (-radius..=radius).map(move |dx| (dx, dy)))
}

/// Interpolates from `a` to `b`.
pub(super) fn lerp(a: f32, b: f32, t: f32) -> f32 {
    a + (b - a) * t
}

/// 0 below `low`, 1 above `high`, smooth between.
pub(super) fn smoothstep(low: f32, high: f32, x: f32) -> f32 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// The largest integer that is not above `x`; the standard library's calls a function where the processor may lack the
/// instruction.
fn floor(x: f32) -> i32 {
    let truncated = x as i32;
    truncated - i32::from(truncated as f32 > x)
}

/// Perlin's quintic, whose second derivative vanishes at the lattice lines.
fn fade(t: f32) -> f32 {
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}

/// C. Wellons' "lowbias32" integer hash (public domain).
fn mix_bits(mut bits: u32) -> u32 {
    bits = (bits ^ (bits >> 16)).wrapping_mul(0x7FEB_352D);
    bits = (bits ^ (bits >> 15)).wrapping_mul(0x846C_A68B);
    bits ^ (bits >> 16)
}

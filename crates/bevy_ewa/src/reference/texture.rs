//! A texture with its mip chain, and a texture unit's lookups.

use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// A colour in linear light: red, green, blue and alpha.
pub type Color = [f64; 4];

/// Addressing of texels beyond the border of a texture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AddressMode {
    /// Repeats the texture.
    #[default]
    Repeat,
    /// Repeats the texture with every second copy mirrored.
    MirrorRepeat,
    /// Repeats the outermost texels.
    ClampToEdge,
    /// Reads transparent black.
    ClampToBorder,
}

impl AddressMode {
    /// Returns the index of the texel to read for any `index` in a row of `length` texels; `None` is the
    /// border colour.
    pub fn wrap(self, index: i64, length: u32) -> Option<u32> {
        let length = i64::from(length);
        let wrapped = match self {
            Self::Repeat => index.rem_euclid(length),
            Self::MirrorRepeat => {
                let folded = index.rem_euclid(2 * length);
                folded.min(2 * length - 1 - folded)
            }
            Self::ClampToEdge => index.clamp(0, length - 1),
            Self::ClampToBorder => index,
        };
        (0..length).contains(&wrapped).then_some(wrapped as u32)
    }
}

/// A mip level.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// Width and height in texels, both at least 1.
    pub size: [u32; 2],
    /// The texels in linear light, in row-major order.
    pub texels: Vec<Color>,
}

impl Level {
    /// Computes the next level: half the size, rounded down, with each texel the mean of the area that
    /// it covers.
    pub fn next(&self) -> Self {
        let size = self.size.map(|n| (n / 2).max(1));
        let weights = [0, 1].map(|axis| area_weights(self.size[axis], size[axis]));
        let mut texels = Vec::with_capacity(size[0] as usize * size[1] as usize);
        for row in &weights[1] {
            for column in &weights[0] {
                let mut sum = [0.0; 4];
                for &(y, wy) in row {
                    for &(x, wx) in column {
                        let texel = self.texels[y as usize * self.size[0] as usize + x as usize];
                        sum = add_weighted(sum, texel, wx * wy);
                    }
                }
                texels.push(sum);
            }
        }
        Self { size, texels }
    }
}

/// Returns, for each of `to` texels, the indices of the `from` texels that it covers, with their
/// fractions of its area.
pub(crate) fn area_weights(from: u32, to: u32) -> Vec<Vec<(u32, f64)>> {
    let scale = f64::from(from) / f64::from(to);
    let covered = |i: u32| {
        let (start, end) = (f64::from(i) * scale, f64::from(i + 1) * scale);
        (start.floor() as u32..(end.ceil() as u32).min(from))
            .map(|j| {
                let part = end.min(f64::from(j + 1)) - start.max(f64::from(j));
                (j, part / scale)
            })
            .filter(|(_, part)| *part > 1e-9)
            .collect()
    };
    (0..to).map(covered).collect()
}

/// A texture that counts its fetches. Each thread needs a clone of its own, because they share the
/// count.
#[derive(Debug)]
pub struct Texture {
    /// Mip levels, the finest first; at least one.
    pub levels: Vec<Level>,
    /// Address modes along u and v.
    pub address: [AddressMode; 2],
    fetches: AtomicU32,
}

impl Clone for Texture {
    fn clone(&self) -> Self {
        Self::from_levels(self.levels.clone(), self.address)
    }
}

impl Texture {
    /// Creates a texture with a full mip chain from its finest level.
    pub fn new(level: Level, address: [AddressMode; 2]) -> Self {
        let mut levels = vec![level];
        while let Some(last) = levels.last()
            && last.size != [1, 1]
        {
            let next = last.next();
            levels.push(next);
        }
        Self::from_levels(levels, address)
    }

    /// Creates a texture of these levels.
    pub fn from_levels(levels: Vec<Level>, address: [AddressMode; 2]) -> Self {
        Self {
            levels,
            address,
            fetches: AtomicU32::new(0),
        }
    }

    /// Creates a repeating texture with a full mip chain from a function of the texel's position.
    pub fn from_fn(size: [u32; 2], color: impl Fn(u32, u32) -> Color) -> Self {
        let positions = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y)));
        let texels = positions.map(|(x, y)| color(x, y)).collect();
        Self::new(Level { size, texels }, [AddressMode::Repeat; 2])
    }

    /// Returns the texture with other address modes.
    pub fn with_address(self, address: [AddressMode; 2]) -> Self {
        Self { address, ..self }
    }

    /// Returns width and height of the finest level in texels.
    pub fn size(&self) -> [u32; 2] {
        self.levels[0].size
    }

    /// Returns the index of the coarsest level.
    pub fn last_level(&self) -> u32 {
        self.levels.len() as u32 - 1
    }

    /// Returns the number of fetches since the last call, and resets it.
    pub fn take_fetches(&self) -> u32 {
        self.fetches.swap(0, Relaxed)
    }

    /// Fetches one texel at integer coordinates of a level.
    pub fn texel(&self, level: u32, position: [i64; 2]) -> Color {
        self.count(self.fetches.load(Relaxed) + 1);
        self.read(level, position)
    }

    /// Fetches bilinearly at a position in texels of a level; the centre of texel 0 is at 0.5.
    pub fn bilinear(&self, level: u32, position: [f64; 2]) -> Color {
        self.count(self.fetches.load(Relaxed) + 1);
        let floor = position.map(|p| (p - 0.5).floor());
        let [fx, fy] = [0, 1].map(|i| position[i] - 0.5 - floor[i]);
        let [x, y] = floor.map(|f| f as i64);
        let row = |y| mix(self.read(level, [x, y]), self.read(level, [x + 1, y]), fx);
        mix(row(y), row(y + 1), fy)
    }

    /// Calls `fetch` and counts all its fetches as one.
    pub fn count_as_one(&self, fetch: impl FnOnce() -> Color) -> Color {
        let previous_fetches = self.fetches.load(Relaxed);
        let color = fetch();
        self.count(previous_fetches + 1);
        color
    }

    /// Fetches trilinearly at texture coordinates, which counts as one fetch.
    pub fn trilinear(&self, uv: [f64; 2], lod: f64) -> Color {
        let lod = lod.clamp(0.0, f64::from(self.last_level()));
        let at = |level: u32| {
            let size = self.levels[level as usize].size;
            self.bilinear(level, [0, 1].map(|i| uv[i] * f64::from(size[i])))
        };
        let fine = lod.floor() as u32;
        self.count_as_one(|| {
            if lod.fract() == 0.0 {
                at(fine)
            } else {
                mix(at(fine), at(fine + 1), lod.fract())
            }
        })
    }

    fn count(&self, fetches: u32) {
        self.fetches.store(fetches, Relaxed);
    }

    fn read(&self, level: u32, position: [i64; 2]) -> Color {
        let level = &self.levels[level as usize];
        let x = self.address[0].wrap(position[0], level.size[0]);
        let y = self.address[1].wrap(position[1], level.size[1]);
        match (x, y) {
            (Some(x), Some(y)) => level.texels[y as usize * level.size[0] as usize + x as usize],
            _ => [0.0; 4],
        }
    }
}

/// Returns `sum + color * weight`.
pub fn add_weighted(sum: Color, color: Color, weight: f64) -> Color {
    [0, 1, 2, 3].map(|i| sum[i] + color[i] * weight)
}

/// Interpolates linearly from `a` at 0 to `b` at 1.
pub fn mix(a: Color, b: Color, t: f64) -> Color {
    [0, 1, 2, 3].map(|i| a[i] + (b[i] - a[i]) * t)
}

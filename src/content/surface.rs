//! Surfaces as functions of a point, from seeded noise that repeats with its tile, and their rendering to images.
//!
//! Gradient noise after K. Perlin, "Improving Noise", SIGGRAPH 2002, on a lattice that wraps; its
//! own few lines rather than a crate, because all that is needed is this wrapping.

use image::{GrayImage, RgbImage, RgbaImage};
use rayon::prelude::*;

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

/// An sRGB-encoded colour, channels 0 to 1.
pub type Color = [f32; 3];

/// The colour of a hexadecimal code such as `0xB2_55_3C`.
pub(super) const fn hex(code: u32) -> Color {
    [
        ((code >> 16) & 0xFF) as f32 / 255.0,
        ((code >> 8) & 0xFF) as f32 / 255.0,
        (code & 0xFF) as f32 / 255.0,
    ]
}

/// Interpolates from `a` to `b`.
pub(super) fn mix(a: Color, b: Color, t: f32) -> Color {
    [0, 1, 2].map(|c| lerp(a[c], b[c], t))
}

/// Multiplies the brightness.
pub(super) fn shade(color: Color, factor: f32) -> Color {
    color.map(|channel| channel * factor)
}

/// Interpolates along evenly spaced colours; `t` is clamped to 0 to 1.
pub(super) fn ramp(stops: &[Color], t: f32) -> Color {
    let position = t.clamp(0.0, 1.0) * (stops.len() - 1) as f32;
    let index = (position as usize).min(stops.len() - 2);
    mix(stops[index], stops[index + 1], position - index as f32)
}

/// Fully saturated colour of a hue of 0 to 1 (red, green, blue, red).
pub(super) fn hue(turn: f32) -> Color {
    [0.0, 2.0 / 3.0, 1.0 / 3.0].map(|offset| {
        let distance = ((turn + offset).rem_euclid(1.0) - 0.5).abs();
        (distance * 6.0 - 1.0).clamp(0.0, 1.0)
    })
}

/// A set of textures of one surface, all of the same size.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Material {
    /// Base colour, sRGB-encoded.
    pub color: RgbImage,
    /// Tangent-space unit normal, `(n + 1) / 2` as 0 to 255 per axis: +X right, +Y up (the
    /// convention of OpenGL and glTF), +Z out of the surface.
    pub normal: RgbImage,
    /// Coverage, 0 to 255: the opacity of foliage, the ink of text; elsewhere what separates the
    /// surface from its gaps and so can serve as a height or occlusion map.
    pub mask: GrayImage,
}

impl Material {
    /// The colour with the mask as its alpha.
    pub fn masked_color(&self) -> RgbaImage {
        RgbaImage::from_fn(self.color.width(), self.color.height(), |x, y| {
            let [r, g, b] = self.color.get_pixel(x, y).0;
            image::Rgba([r, g, b, self.mask.get_pixel(x, y).0[0]])
        })
    }
}

/// A point of a surface.
#[derive(Clone, Copy, Default)]
pub struct Sample {
    pub color: Color,
    /// Height in units, positive out of the surface.
    pub height: f32,
    /// Coverage, 0 to 1.
    pub mask: f32,
}

/// How a surface continues beyond its border.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Border {
    /// It repeats.
    Wrap,
    /// It ends: heights there extend those at the border.
    Clamp,
}

/// Size of an image in units: the short side is one unit, the long one a whole number of them, so
/// that tiles repeat and yet are hardly stretched.
pub(super) fn units(width: u32, height: u32) -> [i32; 2] {
    let short = width.min(height).max(1) as f32;
    [width, height].map(|side| (side as f32 / short).round().max(1.0) as i32)
}

/// Renders a tile, whose samples depend on noise of this seed.
pub(super) fn render_tile(
    width: u32,
    height: u32,
    seed: u64,
    sample: impl Fn(Noise, [f32; 2]) -> Sample + Sync,
) -> Material {
    let noise = Noise::new(seed, units(width, height));
    render(width, height, Border::Wrap, |point| sample(noise, point))
}

/// Renders the surface `sample(point)`, where `point` runs over [`units`] from the top left.
pub(super) fn render(
    width: u32,
    height: u32,
    border: Border,
    sample: impl Fn([f32; 2]) -> Sample + Sync,
) -> Material {
    // Four samples a pixel, enough to keep edges from looking like stairs.
    const OFFSETS: [f32; 2] = [0.25, 0.75];
    let units = units(width, height).map(|units| units as f32);
    let samples: Vec<Sample> = (0..height)
        .into_par_iter()
        .flat_map_iter(|y| (0..width).map(move |x| (x, y)))
        .map(|(x, y)| {
            let mut mean = Sample::default();
            for (dx, dy) in OFFSETS.iter().flat_map(|dy| OFFSETS.map(|dx| (dx, dy))) {
                let s = sample([
                    (x as f32 + dx) / width as f32 * units[0],
                    (y as f32 + dy) / height as f32 * units[1],
                ]);
                mean.color = [0, 1, 2].map(|c| mean.color[c] + s.color[c].clamp(0.0, 1.0) / 4.0);
                mean.height += s.height / 4.0;
                mean.mask += s.mask.clamp(0.0, 1.0) / 4.0;
            }
            mean
        })
        .collect();
    assemble(width, height, border, &samples)
}

/// Encodes samples, given one a pixel in raster order.
pub fn assemble(width: u32, height: u32, border: Border, samples: &[Sample]) -> Material {
    let at = |x: i64, y: i64| {
        let (w, h) = (i64::from(width), i64::from(height));
        let (x, y) = match border {
            Border::Wrap => (x.rem_euclid(w), y.rem_euclid(h)),
            Border::Clamp => (x.clamp(0, w - 1), y.clamp(0, h - 1)),
        };
        &samples[(y * w + x) as usize]
    };
    let units = units(width, height);
    let pixels_per_unit = [
        width as f32 / units[0] as f32,
        height as f32 / units[1] as f32,
    ];
    Material {
        color: RgbImage::from_fn(width, height, |x, y| {
            image::Rgb(at(x.into(), y.into()).color.map(byte))
        }),
        normal: RgbImage::from_fn(width, height, |x, y| {
            let (x, y) = (i64::from(x), i64::from(y));
            let slope_x = (at(x + 1, y).height - at(x - 1, y).height) / 2.0 * pixels_per_unit[0];
            // Rows run down, +Y up.
            let slope_y = (at(x, y - 1).height - at(x, y + 1).height) / 2.0 * pixels_per_unit[1];
            let length = (slope_x * slope_x + slope_y * slope_y + 1.0).sqrt();
            image::Rgb([-slope_x, -slope_y, 1.0].map(|n| byte(n / length * 0.5 + 0.5)))
        }),
        mask: GrayImage::from_fn(width, height, |x, y| {
            image::Luma([byte(at(x.into(), y.into()).mask)])
        }),
    }
}

/// Quantises 0 to 1; values outside saturate.
pub(super) fn byte(value: f32) -> u8 {
    (value * 255.0).round() as u8
}

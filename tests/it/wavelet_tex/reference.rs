//! The filters in f64, over decoded levels: what the shader's are tested against.

use std::collections::BTreeMap;

use bevy::math::Vec2;
use bevy_wavelet_tex::{
    WaveletAddressMode,
    codec::{decoder::DecodedImage, image::WaveletImage},
};

use super::scene::linear;

/// A level in linear units.
pub struct Level {
    size: [u32; 2],
    pub pixels: Vec<[f32; 3]>,
}

/// The levels of an image, as `decode` decodes them.
pub fn levels(image: &WaveletImage, decode: impl Fn(u32) -> DecodedImage) -> Vec<Level> {
    let level = |level| Level::new(image, decode(level));
    (0..image.levels).map(level).collect()
}

impl Level {
    pub fn new(image: &WaveletImage, decoded: DecodedImage) -> Self {
        let (size, pixels) = linear(image, decoded);
        Self { size, pixels }
    }

    fn at(&self, position: [i64; 2], mode: WaveletAddressMode) -> [f64; 3] {
        let inside = |axis: usize| {
            let n = i64::from(self.size[axis]);
            let i = position[axis];
            let i = match mode {
                WaveletAddressMode::Repeat => i.rem_euclid(n),
                WaveletAddressMode::ClampToEdge => i.clamp(0, n - 1),
                WaveletAddressMode::MirrorRepeat => {
                    let i = i.rem_euclid(2 * n);
                    i.min(2 * n - 1 - i)
                }
            };
            i as usize
        };
        let pixel = self.pixels[inside(1) * self.size[0] as usize + inside(0)];
        pixel.map(f64::from)
    }

    /// The nearest pixel.
    pub fn nearest(&self, uv: Vec2, mode: WaveletAddressMode) -> [f64; 3] {
        let position = |axis: usize| (f64::from(uv[axis]) * f64::from(self.size[axis])).floor();
        self.at([position(0) as i64, position(1) as i64], mode)
    }

    /// The four nearest pixels, weighted.
    pub fn bilinear(&self, uv: Vec2, mode: WaveletAddressMode) -> [f64; 3] {
        let place = |axis: usize| {
            let centered = f64::from(uv[axis]) * f64::from(self.size[axis]) - 0.5;
            (centered.floor() as i64, centered - centered.floor())
        };
        let ((x, u), (y, v)) = (place(0), place(1));
        let at = |dx, dy| self.at([x + dx, y + dy], mode);
        let row = |dy| mix(at(0, dy), at(1, dy), u);
        mix(row(0), row(1), v)
    }
}

/// A level and the mips of it that are means of four pixels of the level before, without coding errors.
pub fn exact_mips(level: Level) -> Vec<Level> {
    let mut levels = vec![level];
    while let Some(last) = levels.last()
        && last.size.iter().all(|side| side % 2 == 0)
    {
        let size = last.size.map(|side| i64::from(side / 2));
        let positions = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| [2 * x, 2 * y]));
        let mean = |[x, y]: [i64; 2]| {
            let at = |dx, dy| last.at([x + dx, y + dy], WaveletAddressMode::Repeat);
            let mean = mix(
                mix(at(0, 0), at(1, 0), 0.5),
                mix(at(0, 1), at(1, 1), 0.5),
                0.5,
            );
            mean.map(|value| value as f32)
        };
        let pixels = positions.map(mean).collect();
        let size = last.size.map(|side| side / 2);
        levels.push(Level { size, pixels });
    }
    levels
}

/// The trilinear filter.
pub fn trilinear(levels: &[Level], uv: Vec2, lod: f64, mode: WaveletAddressMode) -> [f64; 3] {
    let fine = lod.floor() as usize;
    let coarse = (fine + 1).min(levels.len() - 1);
    mix(
        levels[fine].bilinear(uv, mode),
        levels[coarse].bilinear(uv, mode),
        lod.fract(),
    )
}

/// The anisotropic filter of `sampling.wesl`, where a pixel of the screen covers `extent` uv along their axes.
pub fn anisotropic(levels: &[Level], uv: Vec2, extent: Vec2, mode: WaveletAddressMode) -> [f64; 3] {
    const MAX_ANISOTROPY: f64 = 9.9;
    const SAMPLE_DENSITY: f64 = 1.2;
    const LONG_FOOTPRINT_BIAS: f64 = 0.45;
    let pixels = [0, 1].map(|axis| f64::from(extent[axis]) * f64::from(levels[0].size[axis]));
    let long = pixels[0].max(pixels[1]);
    let least = (long / MAX_ANISOTROPY).max(1.0);
    let short = pixels[0].min(pixels[1]).max(least);
    let finer = LONG_FOOTPRINT_BIAS * (1.0 - (short / long).powi(2)).clamp(0.0, 1.0);
    let width = short * (-finer).exp2();
    let lod = width.log2().clamp(0.0, (levels.len() - 1) as f64);
    let widths = (long / width).max(1.0);
    let samples = (SAMPLE_DENSITY * widths + 1.0 - SAMPLE_DENSITY).ceil() as u32;
    assert!(samples <= 16, "{samples} samples");
    let half = (1.0 - (width / long).powi(2)).max(0.0).sqrt() as f32;
    let axis = if pixels[0] >= pixels[1] {
        Vec2::X
    } else {
        Vec2::Y
    };
    let (mut sum, mut weights) = ([0.0; 3], 0.0);
    for i in 0..samples {
        let along = f64::from(2 * i + 1) / f64::from(samples) - 1.0;
        let weight = 1.0 - along.abs();
        let at = uv + along as f32 * half * axis * extent;
        let sample = trilinear(levels, at, lod, mode);
        (0..3).for_each(|c| sum[c] += weight * sample[c]);
        weights += weight;
    }
    sum.map(|value| value / weights)
}

/// `a + (b - a) t`.
pub fn mix(a: [f64; 3], b: [f64; 3], t: f64) -> [f64; 3] {
    std::array::from_fn(|c| a[c] + (b[c] - a[c]) * t)
}

/// A level filtered over a footprint of `extent` uv around `uv`, by `taps` x `taps` bilinear samples: with equal
/// weights, or with a tent over twice the footprint, as a texture unit's filter is. Every weight is a product of
/// one along x and one along y, so that each texel is read once.
pub fn supersampled(level: &Level, uv: Vec2, extent: Vec2, taps: u32, tent: bool) -> [f64; 3] {
    let weights = [0, 1].map(|axis| {
        let texels = f64::from(level.size[axis]);
        let centre = f64::from(uv[axis]) * texels - 0.5;
        weights_of_texels(centre, f64::from(extent[axis]) * texels, taps, tent)
    });
    let mut sum = [0.0; 3];
    for (y, weight_y) in &weights[1] {
        for (x, weight_x) in &weights[0] {
            let texel = level.at([*x, *y], WaveletAddressMode::Repeat);
            (0..3).for_each(|c| sum[c] += weight_x * weight_y * texel[c]);
        }
    }
    sum
}

/// The texels along one axis and their weights, one in all, where `taps` linear samples are spread over `extent`
/// texels around `centre`.
fn weights_of_texels(centre: f64, extent: f64, taps: u32, tent: bool) -> BTreeMap<i64, f64> {
    let mut weights = BTreeMap::new();
    for tap in 0..taps {
        let offset = (f64::from(tap) + 0.5) / f64::from(taps) - 0.5;
        let (offset, weight) = if tent {
            (2.0 * offset, 1.0 - 2.0 * offset.abs())
        } else {
            (offset, 1.0)
        };
        let position = centre + offset * extent;
        let (first, fraction) = (position.floor(), position - position.floor());
        *weights.entry(first as i64).or_insert(0.0) += weight * (1.0 - fraction);
        *weights.entry(first as i64 + 1).or_insert(0.0) += weight * fraction;
    }
    let total: f64 = weights.values().sum();
    weights.values_mut().for_each(|weight| *weight /= total);
    weights
}

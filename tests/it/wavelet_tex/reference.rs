//! The filters in f64, over decoded levels: what the shader's are tested against.

use bevy::math::Vec2;
use bevy_wavelet_tex::{
    WaveletAddressMode,
    codec::{decoder::DecodedImage, image::WaveletImage},
};

use super::scene::linear;

/// A level in linear units.
pub struct Level {
    size: [u32; 2],
    pixels: Vec<[f32; 3]>,
}

/// The levels of an image, as `decode` decodes them.
pub fn levels(image: &WaveletImage, decode: impl Fn(u32) -> DecodedImage) -> Vec<Level> {
    let level = |level| {
        let (size, pixels) = linear(image, decode(level));
        Level { size, pixels }
    };
    (0..image.levels).map(level).collect()
}

impl Level {
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

/// `a + (b - a) t`.
pub fn mix(a: [f64; 3], b: [f64; 3], t: f64) -> [f64; 3] {
    std::array::from_fn(|c| a[c] + (b[c] - a[c]) * t)
}

/// Level 0 filtered over a footprint of `extent` uv around `uv`, by `taps` x `taps` bilinear samples:
/// with equal weights, or with a tent over twice the footprint, as a texture unit's filter is.
pub fn supersampled(level: &Level, uv: Vec2, extent: Vec2, taps: u32, tent: bool) -> [f64; 3] {
    let (mut sum, mut weights) = ([0.0; 3], 0.0);
    for y in 0..taps {
        for x in 0..taps {
            let mut offset = (Vec2::new(x as f32, y as f32) + 0.5) / taps as f32 - 0.5;
            let mut weight = 1.0;
            if tent {
                offset *= 2.0;
                weight = f64::from((1.0 - offset.x.abs()) * (1.0 - offset.y.abs()));
            }
            let sample = level.bilinear(uv + offset * extent, WaveletAddressMode::Repeat);
            (0..3).for_each(|c| sum[c] += weight * sample[c]);
            weights += weight;
        }
    }
    sum.map(|v| v / weights)
}

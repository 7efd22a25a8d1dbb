//! A frame as a texture stores it: channels of unsigned integers.

use bevy_ycocg_fb::reference::{PackedPixel, pack::sanitized, rg11b10ufloat::dithered, unorm8};
use half::f16;

use super::{frame::Frame, layouts::Layout, settings::REFERENCE};

/// A frame in a format.
pub struct Surface {
    /// Its name in the records.
    pub name: String,
    /// Width and height in pixels.
    pub size: [u32; 2],
    pub channels: Vec<Channel>,
}

/// A channel, whose integers have the order of its values.
pub struct Channel {
    pub bits: u32,
    /// Row after row from the top left.
    pub values: Vec<u32>,
}

impl Surface {
    /// A surface with channels of so many bits, whose values come from pixel positions.
    pub fn new(
        name: String,
        size: [u32; 2],
        bits: &[u32],
        values: impl Fn(u32, u32) -> Vec<u32>,
    ) -> Self {
        let mut channels: Vec<_> = bits
            .iter()
            .map(|&bits| Channel {
                bits,
                values: Vec::new(),
            })
            .collect();
        for (x, y) in (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y))) {
            for (channel, value) in channels.iter_mut().zip(values(x, y)) {
                channel.values.push(value);
            }
        }
        Self {
            name,
            size,
            channels,
        }
    }

    pub fn bits_per_pixel(&self) -> u32 {
        self.channels.iter().map(|channel| channel.bits).sum()
    }

    /// Bytes without compression.
    pub fn bytes(&self) -> u64 {
        let pixels = u64::from(self.size[0]) * u64::from(self.size[1]);
        pixels * u64::from(self.bits_per_pixel()) / 8
    }

    /// The corners of blocks that cover the surface.
    pub fn blocks(&self, size: [u32; 2]) -> impl Iterator<Item = [u32; 2]> + use<> {
        let [columns, rows] = [0, 1].map(|axis| self.size[axis].div_ceil(size[axis]));
        (0..rows).flat_map(move |y| (0..columns).map(move |x| [x * size[0], y * size[1]]))
    }

    /// The value of a channel; beyond the border, of the nearest pixel.
    pub fn value(&self, channel: &Channel, x: u32, y: u32) -> u32 {
        let [x, y] = [x.min(self.size[0] - 1), y.min(self.size[1] - 1)];
        channel.values[(y * self.size[0] + x) as usize]
    }
}

/// A frame in each format, and packed in each layout. `display` is what a display shows of it, sRGB-encoded.
pub fn surfaces(frame: &Frame, display: &Frame) -> Vec<Surface> {
    let size = frame.size;
    let mut surfaces = vec![
        Surface::new(REFERENCE.into(), size, &[16; 4], |x, y| {
            let [r, g, b] = sanitized(frame.at(x, y)).map(half);
            vec![r, g, b, half(1.0)]
        }),
        Surface::new("rg11b10ufloat".into(), size, &[11, 11, 10], |x, y| {
            small_floats(dithered(frame.at(x, y), x, y))
        }),
        Surface::new(
            "rg11b10ufloat without dither".into(),
            size,
            &[11, 11, 10],
            |x, y| small_floats(sanitized(frame.at(x, y))),
        ),
    ];
    surfaces.extend(Layout::ALL.map(|layout| {
        let name = format!("float16 {}", layout.name());
        Surface::new(name, size, &[16; 2], |x, y| {
            let pixel = layout.packed(frame.at(x, y), x, y);
            [pixel.luminance, pixel.chrominance].map(half).into()
        })
    }));
    surfaces.push(Surface::new("rgba8".into(), size, &[8; 4], |x, y| {
        let [r, g, b] = display.at(x, y).map(byte);
        vec![r, g, b, byte(1.0)]
    }));
    surfaces.extend(Layout::ALL.map(|layout| {
        let name = format!("unorm8 {}", layout.name());
        Surface::new(name, size, &[8; 2], |x, y| {
            let PackedPixel {
                luminance,
                chrominance,
            } = unorm8::code(layout.packed(display.at(x, y), x, y));
            [luminance, chrominance].map(byte).into()
        })
    }));
    surfaces
}

fn byte(value: f32) -> u32 {
    (value.clamp(0.0, 1.0) * 255.0).round() as u32
}

/// A 16-bit float such that a larger value has a larger integer.
fn half(value: f32) -> u32 {
    let value = f16::from_f32(value);
    let bits = value.to_bits();
    u32::from(if value.is_sign_negative() {
        !bits
    } else {
        bits | 0x8000
    })
}

/// Floats of 11, 11 and 10 bits, rounded to nearest: 16-bit floats without their sign and the last bits of their
/// mantissa.
fn small_floats(rgb: [f32; 3]) -> Vec<u32> {
    let pairs = rgb.into_iter().zip([4, 4, 5]);
    let rounded = pairs.map(|(value, dropped)| {
        let bits = u32::from(f16::from_f32(value).to_bits());
        (bits + (1 << (dropped - 1))) >> dropped
    });
    rounded.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn floats_keep_their_order() {
        let values = [-65504.0, -1.0, -1e-4, 0.0, 1e-4, 1.0, 65504.0].map(half);
        assert!(values.is_sorted());
    }

    #[test]
    fn small_floats_are_those_that_the_dither_gives() {
        // 1.5 has the exponent of 15 and the first bit of the mantissa.
        let wanted = vec![15 << 6 | 32, 15 << 6 | 32, 15 << 5 | 16];
        assert_eq!(small_floats([1.5; 3]), wanted);
        assert_eq!(small_floats(dithered([1.5; 3], 3, 8)), wanted);
    }
}

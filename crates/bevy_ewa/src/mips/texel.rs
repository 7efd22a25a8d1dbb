//! Conversion of texel formats to linear light and back.

use half::f16;

/// The layout of texels in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TexelFormat {
    /// Number of channels, 1 to 4.
    pub channels: usize,
    /// Number type of a channel.
    pub storage: Storage,
    /// Whether the first three channels are sRGB-encoded; only used with [`Storage::Unorm8`].
    pub srgb: bool,
}

/// The number type of a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Storage {
    /// An 8-bit normalized value from 0 to 1.
    Unorm8,
    /// A 16-bit normalized value from 0 to 1, little-endian.
    Unorm16,
    /// A 16-bit float, little-endian.
    Float16,
    /// A 32-bit float, little-endian.
    Float32,
}

impl TexelFormat {
    /// Returns the size of a texel in bytes.
    pub fn bytes(self) -> usize {
        self.channels
            * match self.storage {
                Storage::Unorm8 => 1,
                Storage::Unorm16 | Storage::Float16 => 2,
                Storage::Float32 => 4,
            }
    }

    /// Decodes texels to linear light, with the channels interleaved.
    pub fn decode(self, data: &[u8]) -> Vec<f32> {
        match self.storage {
            Storage::Unorm8 => {
                let table: [f32; 256] =
                    std::array::from_fn(|byte| linear_from_srgb(byte as f32 / 255.0));
                let decode = |(i, byte): (usize, &u8)| {
                    if self.is_srgb(i) {
                        table[usize::from(*byte)]
                    } else {
                        f32::from(*byte) / 255.0
                    }
                };
                data.iter().enumerate().map(decode).collect()
            }
            Storage::Unorm16 => {
                decode(data, |bytes| f32::from(u16::from_le_bytes(bytes)) / 65535.0)
            }
            Storage::Float16 => decode(data, |bytes| f16::from_le_bytes(bytes).to_f32()),
            Storage::Float32 => decode(data, f32::from_le_bytes),
        }
    }

    /// Encodes interleaved channels in linear light and appends them to `data`.
    pub fn encode(self, values: &[f32], data: &mut Vec<u8>) {
        match self.storage {
            Storage::Unorm8 => data.extend(values.iter().enumerate().map(|(i, value)| {
                let value = value.clamp(0.0, 1.0);
                let encoded = if self.is_srgb(i) {
                    srgb_from_linear(value)
                } else {
                    value
                };
                (encoded * 255.0).round() as u8
            })),
            Storage::Unorm16 => data.extend(values.iter().flat_map(|value| {
                let value = (value.clamp(0.0, 1.0) * 65535.0).round();
                (value as u16).to_le_bytes()
            })),
            Storage::Float16 => {
                data.extend(values.iter().flat_map(|v| f16::from_f32(*v).to_le_bytes()));
            }
            Storage::Float32 => data.extend(values.iter().flat_map(|value| value.to_le_bytes())),
        }
    }

    fn is_srgb(self, index: usize) -> bool {
        self.srgb && index % self.channels < 3
    }
}

fn decode<const BYTES: usize>(data: &[u8], value: impl Fn([u8; BYTES]) -> f32) -> Vec<f32> {
    let (chunks, _) = data.as_chunks();
    chunks.iter().map(|bytes| value(*bytes)).collect()
}

/// Decodes an sRGB-encoded value of 0 to 1 to linear light, 0 to 1.
pub fn linear_from_srgb(value: f32) -> f32 {
    if value <= 0.04045 {
        value / 12.92
    } else {
        ((value + 0.055) / 1.055).powf(2.4)
    }
}

/// Encodes a value in linear light, 0 to 1, as sRGB, 0 to 1.
pub fn srgb_from_linear(value: f32) -> f32 {
    if value <= 0.003_130_8 {
        value * 12.92
    } else {
        1.055 * value.powf(1.0 / 2.4) - 0.055
    }
}

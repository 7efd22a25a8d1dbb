//! How planes are packed into block-compressed textures (thesis section 3.5.3).

use serde::{Deserialize, Serialize};

use super::blocks::BlockFormat;

/// How the planes of a group are packed into textures. Files and shaders have the number of the packing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Packing {
    /// Wavelet at 2 bpp: the detail bands in RGB of BC3, the low band in alpha, which BC3 codes
    /// independently.
    Bc3,
    /// Wavelet at 2 bpp: HL, LH and the low band in RGB of BC7. HH is dropped (thesis section
    /// 3.5.1).
    Bc7,
    /// Wavelet at 3 bpp: the low band in BC4, the detail bands in a BC7 texture of their own.
    Split,
    /// The pixels of the plane in BC4 without a wavelet, 4 bpp.
    Bc4,
    /// The pixels of two planes in one BC1 texture without a wavelet, 4 bpp: the first plane in R
    /// and B, whose mean has one bit more than either, the second in G. The texture unit
    /// interpolates between pixels.
    Bc1,
}

impl Packing {
    /// All packings, in the order of their numbers.
    pub const ALL: [Self; 5] = [Self::Bc3, Self::Bc7, Self::Split, Self::Bc4, Self::Bc1];

    /// Block formats of the packing's textures.
    pub fn formats(self) -> &'static [BlockFormat] {
        match self {
            Self::Bc3 => &[BlockFormat::Bc3],
            Self::Bc7 => &[BlockFormat::Bc7],
            Self::Split => &[BlockFormat::Bc4, BlockFormat::Bc7],
            Self::Bc4 => &[BlockFormat::Bc4],
            Self::Bc1 => &[BlockFormat::Bc1],
        }
    }

    /// Returns whether a texel holds the coefficients of 2 x 2 pixels instead of one pixel.
    pub fn is_wavelet(self) -> bool {
        matches!(self, Self::Bc3 | Self::Bc7 | Self::Split)
    }

    /// Number of layers of the packing's textures for this number of planes.
    pub fn layers(self, planes: usize) -> usize {
        if self == Self::Bc1 { 1 } else { planes }
    }

    /// Bits that one layer takes for each pixel of the plane.
    pub fn bits_per_pixel(self) -> f64 {
        let bits = |f: &BlockFormat| 8.0 * f.block_bytes() as f64 / 16.0;
        let texels: f64 = if self.is_wavelet() { 0.25 } else { 1.0 };
        texels * self.formats().iter().map(bits).sum::<f64>()
    }

    /// Name of the packing in the tool's output.
    pub fn name(self) -> &'static str {
        match self {
            Self::Bc3 => "bc3",
            Self::Bc7 => "bc7",
            Self::Split => "bc4+bc7",
            Self::Bc4 => "bc4",
            Self::Bc1 => "bc1",
        }
    }
}

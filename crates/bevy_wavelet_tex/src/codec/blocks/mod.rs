//! BC blocks: 4 x 4 texels in 8 or 16 bytes.
//!
//! | file | contents |
//! | --- | --- |
//! | `decode` | decodes BC1, BC3, BC4, BC5 and BC7 blocks to texels |
//! | `fit` | the search for endpoints by the error in pixels; `color` encodes BC1 and BC3 blocks with it |
//! | `interpolated` | refines BC1 blocks by the error of the pixels between their texels |
//! | `libraries` | encodes BC4 and BC3 with `dds`, and BC7 with `ctt-bc7enc-rdo` (bc7e) |
//!
//! BC1 and the colour half of BC3 have an encoder of their own because no library minimises the
//! error that matters here: that of the coefficients after the power curve is inverted, with two
//! channels that stand for one value.

#[cfg(feature = "encode")]
mod color;
mod decode;
#[cfg(feature = "encode")]
mod fit;
#[cfg(feature = "encode")]
mod interpolated;
#[cfg(feature = "encode")]
mod libraries;

#[cfg(feature = "encode")]
pub(super) use color::is_dark;
#[cfg(feature = "encode")]
pub use color::{ChromaEncoder, ColorEncoder, DetailEncoder, with_alpha_blocks};
pub use decode::{decode_bc3, decode_blocks};
#[cfg(feature = "encode")]
pub use fit::Starts;
#[cfg(feature = "encode")]
pub use libraries::{
    BlockQuality, encode_bc1, encode_bc3, encode_bc4, encode_bc7, encode_bc7_rgba,
};

/// An RGBA texel, 8 bits a channel.
pub type Texel = [u8; 4];

/// A block format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum BlockFormat {
    /// RGB, 8 bytes.
    Bc1,
    /// RGB as in BC1 and alpha as in BC4, 16 bytes.
    Bc3,
    /// One channel, 8 bytes.
    Bc4,
    /// Two channels as in BC4, 16 bytes.
    Bc5,
    /// RGBA, 16 bytes.
    Bc7,
}

impl BlockFormat {
    /// All formats; a file stores the index of that of a plain texture.
    pub const ALL: [Self; 5] = [Self::Bc1, Self::Bc3, Self::Bc4, Self::Bc5, Self::Bc7];

    /// Name of the format in the tool's output.
    pub fn name(self) -> &'static str {
        match self {
            Self::Bc1 => "bc1",
            Self::Bc3 => "bc3",
            Self::Bc4 => "bc4",
            Self::Bc5 => "bc5",
            Self::Bc7 => "bc7",
        }
    }

    /// Bytes of one block.
    pub fn block_bytes(self) -> usize {
        match self {
            Self::Bc1 | Self::Bc4 => 8,
            Self::Bc3 | Self::Bc5 | Self::Bc7 => 16,
        }
    }

    /// Bytes of one level of one layer of `size` texels.
    pub fn level_bytes(self, size: [u32; 2]) -> usize {
        let blocks = size.map(|s| s.div_ceil(4) as usize);
        blocks[0] * blocks[1] * self.block_bytes()
    }
}

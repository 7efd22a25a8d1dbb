//! 4 x 4 texels and the 8 or 16 bytes that hold them.
//!
//! | file | what is in it |
//! | --- | --- |
//! | `decode` | BC1, BC3, BC4 and BC7 blocks to texels |
//! | `fit` | the search for end points by the error in pixels; `color` makes BC1 and BC3 blocks of it |
//! | `libraries` | BC4 and BC3 of `dds`, BC7 of `ctt-bc7enc-rdo` (bc7e) |
//!
//! BC3's colours and BC1 have an encoder of their own because no library minimises the error that
//! counts here: that of the coefficients, behind a power curve, with two channels that stand for one
//! value.

#[cfg(feature = "encode")]
mod color;
mod decode;
#[cfg(feature = "encode")]
mod fit;
#[cfg(feature = "encode")]
mod libraries;

#[cfg(feature = "encode")]
pub use color::{ChromaEncoder, DetailEncoder, with_alpha_blocks};
pub use decode::{decode_bc3, decode_blocks};
#[cfg(feature = "encode")]
pub use fit::Starts;
#[cfg(feature = "encode")]
pub use libraries::{BlockQuality, encode_bc1, encode_bc3, encode_bc4, encode_bc7};

/// An RGBA texel, 8 bits a channel.
pub type Texel = [u8; 4];

/// A block format, always linear: coefficients are no colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum BlockFormat {
    /// RGB, 8 bytes.
    Bc1,
    /// RGB as BC1's and alpha as BC4's, 16 bytes.
    Bc3,
    /// One channel, 8 bytes.
    Bc4,
    /// RGBA, 16 bytes.
    Bc7,
}

impl BlockFormat {
    /// Bytes of a block.
    pub fn block_bytes(self) -> usize {
        match self {
            Self::Bc1 | Self::Bc4 => 8,
            Self::Bc3 | Self::Bc7 => 16,
        }
    }

    /// Bytes of one level of one layer whose size in texels is `size`.
    pub fn level_bytes(self, size: [u32; 2]) -> usize {
        let blocks = size.map(|s| s.div_ceil(4) as usize);
        blocks[0] * blocks[1] * self.block_bytes()
    }
}

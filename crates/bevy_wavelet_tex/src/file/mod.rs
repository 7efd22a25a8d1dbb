//! The `.wtex` file: a small header and, for each texture of a group of planes or for the plain
//! texture, a KTX2 blob that is complete by itself.
//!
//! One KTX2 file has one size and one format, so luma and the smaller chroma cannot share one. Each
//! blob is a complete KTX2 file (one array layer for each plane, all mips) whose key `wtex.codings`
//! describes how its planes are stored, so any KTX2 tool can show the coefficients. (Where sides are no powers of
//! two, small levels can have a block more than KTX2 expects, and there can be a level more: see
//! [`layout`](crate::codec::layout).) With Zstandard, which
//! is KTX2's supercompression scheme 2, each mip level is a frame of its own.
//!
//! | bytes | little-endian |
//! | --- | --- |
//! | 8 | magic `WTEX\r\n\x1a\n`, which text-mode copies break |
//! | 1 | version: 2, 3 of an image with a [plain texture], or 4 of one with fitted [axes] of colour |
//! | 1 | flags: 1 where the blobs are compressed with Zstandard, 2 where the file ends with a fingerprint |
//! | 1 | content: 0 gray, 1 colour, 2 normal, 3 colour with alpha |
//! | 1 | colour space: 0 linear, 1 sRGB |
//! | 4 + 4 | width, height in pixels |
//! | 4 | number of groups: 1, or 2 with chroma; 0 of an image with a plain texture |
//! | 36 | of version 4: RGB of one unit of luma and of each plane of chroma, as nine `f32` |
//! | 12 each | for each group: subsampling, packing (its index in [`Packing::ALL`]), two bytes 0, and the length of its one or two KTX2 blobs in bytes (0 for none) |
//! | 16 | of a plain texture, in place of groups: format (its index in [`BlockFormat::ALL`]), three bytes 0, width and height in texels, and the length of its KTX2 blob in bytes |
//! | the rest | the blobs, one after the other |
//! | 8 | with its flag, the fingerprint of what the file was made of, by which an encoder knows that nothing has changed |
//!
//! [plain texture]: crate::codec::plain
//! [axes]: crate::codec::axes
//! [`Packing::ALL`]: crate::codec::packing::Packing::ALL
//! [`BlockFormat::ALL`]: crate::codec::blocks::BlockFormat::ALL

mod ktx2_blob;
mod read;
mod write;
pub mod zstd;

pub use read::{ReadError, is_texture, read, read_at_most};
#[cfg(feature = "zstd_encode")]
pub use write::write_zstd;
pub use write::{fingerprint, version, with_fingerprint, write};

/// Extension of the file name.
pub const EXTENSION: &str = "wtex";

/// The newest file version, which is that of images with fitted axes of colour. Others are written as
/// earlier versions, so that earlier releases read them; version 1 was never released.
pub const VERSION: u16 = 4;

/// File version of images with groups of planes in YCoCg.
const PLANES_VERSION: u16 = 2;

/// File version of images with a plain texture.
const PLAIN_VERSION: u16 = 3;

/// The flag of files compressed with Zstandard. Releases that know no flags read it as a part of the
/// version, and refuse it as newer than theirs.
const ZSTD_FLAG: u8 = 1;

/// The flag of files that end with a fingerprint.
const FINGERPRINT_FLAG: u8 = 2;

/// Position of the flags.
const FLAGS_AT: usize = 9;

const MAGIC: [u8; 8] = *b"WTEX\r\n\x1a\n";

/// Bytes of the header before the groups.
const FIXED_HEADER_BYTES: usize = 24;

/// Bytes of the header for axes of colour.
const AXES_BYTES: usize = 36;

/// Bytes of the header for each group.
const GROUP_BYTES: usize = 12;

/// Bytes of the header for a plain texture.
const PLAIN_BYTES: usize = 16;

#[cfg(all(test, feature = "encode"))]
mod tests;

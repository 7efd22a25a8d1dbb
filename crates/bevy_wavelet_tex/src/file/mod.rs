//! The `.wtex` file: a small header and, for each group of planes, a KTX2 blob that stands alone.
//!
//! One KTX2 has one size, so luma and half-size chroma cannot share it. Each blob is a complete
//! KTX2 file (BC3, an array layer for each plane, all mips) whose key `wtex.codings` says how its
//! planes are stored: any KTX2 tool shows the coefficients.
//!
//! | bytes | little-endian |
//! | --- | --- |
//! | 8 | magic `WTEX\r\n\x1a\n`, which text-mode copies break |
//! | 2 | version, [`VERSION`] |
//! | 1 | content: 0 gray, 1 colour, 2 normal |
//! | 1 | colour space: 0 linear, 1 sRGB |
//! | 4 + 4 | width, height in pixels |
//! | 4 | number of groups |
//! | 4 each | length of each group's KTX2 blob in bytes |
//! | the rest | the blobs, one after the other |

mod ktx2_blob;
mod read;
mod write;

pub use read::{ReadError, read};
pub use write::write;

/// The file name's extension.
pub const EXTENSION: &str = "wtex";

/// Version that is written, and the newest that is read.
pub const VERSION: u16 = 1;

const MAGIC: [u8; 8] = *b"WTEX\r\n\x1a\n";

/// Bytes before the lengths of the blobs.
const FIXED_HEADER_BYTES: usize = 24;

#[cfg(all(test, feature = "encode"))]
mod tests;

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

/// Zstandard frames, read by the crate that Bevy itself uses to read KTX2.
pub mod zstd {
    /// Decompresses a frame of exactly `length` bytes, or returns what is wrong with it.
    ///
    /// The result grows as it is decompressed, so a wrong `length` allocates no more than the frame has. The
    /// window, which a frame can make larger than itself, is at most `length` or 8 MiB, what every decoder has
    /// to support (RFC 8878, section 3.1.1.1.2).
    ///
    /// # Errors
    /// Returns the reason, and the remedy where there is one.
    #[cfg(feature = "zstd")]
    pub fn decompress(frame: &[u8], length: usize) -> Result<Vec<u8>, String> {
        use ruzstd::decoding::StreamingDecoder;
        use std::io::Read;

        let fail =
            |error: &dyn std::fmt::Display| format!("its Zstandard data is damaged: {error}");
        let window = (length as u64).max(8 << 20);
        let mut rest = frame;
        let mut decoder = StreamingDecoder::new_with_max_window_size(&mut rest, window)
            .map_err(|error| fail(&error))?;
        let mut bytes = Vec::new();
        let most = length as u64 + 1;
        let read = (&mut decoder).take(most).read_to_end(&mut bytes);
        read.map_err(|error| fail(&error))?;
        if bytes.len() > length {
            return Err(fail(&format_args!("it has more than {length} bytes")));
        }
        if bytes.len() < length {
            return Err(fail(&format_args!(
                "it has {} bytes instead of {length}",
                bytes.len()
            )));
        }
        if !rest.is_empty() {
            return Err(fail(&format_args!("{} bytes follow it", rest.len())));
        }
        Ok(bytes)
    }

    /// The stand-in of a build that refuses compressed files by their headers.
    #[cfg(not(feature = "zstd"))]
    pub(super) fn decompress(_frame: &[u8], _length: usize) -> Result<Vec<u8>, String> {
        Err(super::ReadError::ZstdDisabled.to_string())
    }

    /// Makes a frame that states its length, at a `level` from 1 to 22.
    #[cfg(feature = "zstd_encode")]
    pub(super) fn compress(bytes: &[u8], level: i32) -> Vec<u8> {
        ::zstd::bulk::compress(bytes, level.clamp(1, 22)).expect("memory is all that it needs")
    }
}

#[cfg(all(test, feature = "encode"))]
mod tests;

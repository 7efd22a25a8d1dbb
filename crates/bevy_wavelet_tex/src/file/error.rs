//! The reason why a file is not read.

use thiserror::Error;

use super::VERSION;
use crate::codec::layout::MAX_SIZE;

/// The reason why bytes are not a wavelet texture. A caller that knows the name of the file puts it
/// in front of the message.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The file begins with the bytes of another format.
    #[error(
        "not a wavelet texture: it does not begin with the bytes of a .wtex file (was it made by \
         `wavelet-tex encode`?)"
    )]
    Magic,
    /// The file was written by a later release.
    #[error(
        "file version {0} is newer than {VERSION}, the newest this release reads: update \
         bevy_wavelet_tex or encode the texture again"
    )]
    Version(u16),
    /// The file was written before the first release.
    #[error("file version {0} was never released: encode the texture again")]
    OldVersion(u16),
    /// The file is compressed, and this build cannot decompress it.
    #[error(
        "it is compressed with Zstandard: enable the feature `zstd` of bevy_wavelet_tex, or encode the \
         texture without"
    )]
    ZstdDisabled,
    /// The file ends too early.
    #[error("the file is cut short: {needed} bytes are needed for its {part}, it has {available}")]
    Truncated {
        /// The part of the file that is incomplete.
        part: &'static str,
        /// Length in bytes that the file needs at least to contain the part.
        needed: u64,
        /// Length of the file in bytes.
        available: usize,
    },
    /// The file is longer than its header says.
    #[error("{0} bytes follow the end of the texture: the file is damaged")]
    TrailingBytes(usize),
    /// A side of the image is out of range.
    #[error("an image of {} x {} pixels: both sides must be 1 to {MAX_SIZE}", .0[0], .0[1])]
    Size([u32; 2]),
    /// A field of the header has an invalid value.
    #[error("the header's {field} is {value}, which is invalid: the file is damaged")]
    Field {
        /// Name of the field.
        field: &'static str,
        /// Value of the field.
        value: u32,
    },
    /// The axes of colour are not those of an image.
    #[error(
        "the header's axes of colour are out of range, or the image has no colour: the file is damaged"
    )]
    Axes,
    /// The KTX2 blob of a plain texture is damaged or does not match the header.
    #[error("the KTX2 data of the plain texture is damaged: {0}")]
    PlainBlob(String),
    /// A KTX2 blob is damaged or does not match the header.
    #[error("the KTX2 data of plane group {group} is damaged: {reason}")]
    Blob {
        /// Index of the plane group, from 0.
        group: usize,
        /// Description of the damage.
        reason: String,
    },
}

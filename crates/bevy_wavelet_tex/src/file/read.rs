//! Reading a `.wtex` file. No input panics, and nothing is allocated that the file does not hold.

use thiserror::Error;

use super::{FIXED_HEADER_BYTES, MAGIC, VERSION, ktx2_blob};
use crate::codec::{
    image::{ColorSpace, Content, WaveletImage},
    layout::{self, MAX_SIZE},
};

/// Why bytes are not a wavelet texture. Who knows the file's name puts it before.
#[derive(Debug, Error)]
pub enum ReadError {
    /// The first bytes are another file's.
    #[error(
        "not a wavelet texture: it does not begin with the bytes of a .wtex file (was it made by \
         `wavelet-tex encode`?)"
    )]
    Magic,
    /// Made by a later release.
    #[error(
        "file version {0} is newer than {VERSION}, the newest this release reads: update \
         bevy_wavelet_tex or encode the texture again"
    )]
    Version(u16),
    /// The file ends too early.
    #[error("the file is cut short: {needed} bytes are needed for its {part}, it has {available}")]
    Truncated {
        /// What is missing.
        part: &'static str,
        /// Length of file or part that is needed at least, in bytes.
        needed: u64,
        /// Length that is there, in bytes.
        available: usize,
    },
    /// There is more than the header tells of.
    #[error("{0} bytes follow the end of the texture: the file is damaged")]
    TrailingBytes(usize),
    /// A side of the image is out of range.
    #[error("an image of {} x {} pixels: both sides must be 1 to {MAX_SIZE}", .0[0], .0[1])]
    Size([u32; 2]),
    /// A field of the header has no meaning.
    #[error("the header's {field} is {value}, which has no meaning: the file is damaged")]
    Field {
        /// Its name.
        field: &'static str,
        /// Its value.
        value: u32,
    },
    /// A blob is not the KTX2 that it should be.
    #[error("the KTX2 data of plane group {group} is damaged: {reason}")]
    Blob {
        /// Which, from 0.
        group: usize,
        /// What is wrong with it.
        reason: String,
    },
}

/// Reads a file.
///
/// # Errors
/// See [`ReadError`]; each names what is wrong and, where there is one, the remedy.
pub fn read(bytes: &[u8]) -> Result<WaveletImage, ReadError> {
    let magic = bytes.get(..MAGIC.len()).unwrap_or(bytes);
    if magic.is_empty() || !MAGIC.starts_with(magic) {
        return Err(ReadError::Magic);
    }
    let truncated = |part, needed: u64| ReadError::Truncated {
        part,
        needed,
        available: bytes.len(),
    };
    let header = bytes
        .get(..FIXED_HEADER_BYTES)
        .ok_or_else(|| truncated("header", FIXED_HEADER_BYTES as u64))?;
    let u32_at = |at: usize| u32::from_le_bytes([0, 1, 2, 3].map(|i| bytes[at + i]));

    let version = u16::from_le_bytes([header[8], header[9]]);
    match version {
        1..=VERSION => {}
        0 => {
            return Err(ReadError::Field {
                field: "version",
                value: 0,
            });
        }
        newer => return Err(ReadError::Version(newer)),
    }
    let content = match header[10] {
        0 => Content::Gray,
        1 => Content::Color,
        2 => Content::Normal,
        value => {
            return Err(ReadError::Field {
                field: "content",
                value: value.into(),
            });
        }
    };
    let color_space = match header[11] {
        0 => ColorSpace::Linear,
        1 => ColorSpace::Srgb,
        value => {
            return Err(ReadError::Field {
                field: "colour space",
                value: value.into(),
            });
        }
    };
    let size = [u32_at(12), u32_at(16)];
    if size.iter().any(|s| !(1..=MAX_SIZE).contains(s)) {
        return Err(ReadError::Size(size));
    }
    let shapes = content.groups();
    let group_count = u32_at(20);
    if group_count as usize != shapes.len() {
        return Err(ReadError::Field {
            field: "number of plane groups",
            value: group_count,
        });
    }

    let blobs_start = FIXED_HEADER_BYTES + 4 * shapes.len();
    if bytes.len() < blobs_start {
        return Err(truncated("header", blobs_start as u64));
    }
    let lengths: Vec<u64> = (0..shapes.len())
        .map(|i| u32_at(FIXED_HEADER_BYTES + 4 * i).into())
        .collect();
    let end = blobs_start as u64 + lengths.iter().sum::<u64>();
    if end > bytes.len() as u64 {
        return Err(truncated("planes", end));
    }
    if end < bytes.len() as u64 {
        return Err(ReadError::TrailingBytes(bytes.len() - end as usize));
    }

    let mut start = blobs_start;
    let mut levels = None;
    let mut groups = Vec::with_capacity(shapes.len());
    for (group, (shape, length)) in shapes.iter().zip(lengths).enumerate() {
        let blob_error = |reason| ReadError::Blob { group, reason };
        let blob = &bytes[start..start + length as usize];
        start += length as usize;
        let texture = layout::texture_size(layout::plane_size(size, shape.subsampling));
        let most = layout::max_level_count(size, &[shape.subsampling]);
        let (group_levels, plane_group) =
            ktx2_blob::read(blob, texture, shape.planes, most).map_err(blob_error)?;
        if levels.is_some_and(|levels| levels != group_levels) {
            return Err(blob_error(format!(
                "it has {group_levels} mip levels, not as many as the group before"
            )));
        }
        levels = Some(group_levels);
        groups.push(plane_group);
    }
    Ok(WaveletImage {
        content,
        color_space,
        size,
        levels: levels.unwrap_or(1),
        groups,
    })
}

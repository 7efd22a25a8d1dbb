//! The conditions that an image must meet to be encoded.

use thiserror::Error;

use super::{
    layout,
    source::{Source, level_pixels},
};

/// The reason why an image cannot be encoded.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum EncodeError {
    /// A side of the image is 0 or larger than [`layout::MAX_SIZE`].
    #[error("an image of {} x {} pixels cannot be encoded: both sides must be 1 to {}", .0[0], .0[1], layout::MAX_SIZE)]
    Size([u32; 2]),
    /// A level does not have as many pixels as the size requires.
    #[error(
        "mip level {level} of an image of {} x {} pixels should have {wanted} pixels, it has \
         {pixels}",
        .size[0], .size[1]
    )]
    PixelCount {
        /// Width and height of the image in pixels.
        size: [u32; 2],
        /// The mip level; 0 is the image itself.
        level: usize,
        /// Number of pixels that the level should have.
        wanted: u64,
        /// Number of pixels that were given.
        pixels: usize,
    },
    /// The image has no mip level.
    #[error("an image without a mip level cannot be encoded")]
    NoLevel,
}

pub(super) fn check(source: &Source<'_>) -> Result<(), EncodeError> {
    let size = source.size;
    if size.iter().any(|s| !(1..=layout::MAX_SIZE).contains(s)) {
        return Err(EncodeError::Size(size));
    }
    if source.levels.is_empty() {
        return Err(EncodeError::NoLevel);
    }
    for (level, pixels) in source.levels.iter().enumerate() {
        let wanted = level_pixels(size, level);
        if pixels.len() as u64 != wanted {
            return Err(EncodeError::PixelCount {
                size,
                level,
                wanted,
                pixels: pixels.len(),
            });
        }
    }
    Ok(())
}

//! The part of a file that holds a plain texture.

use super::{
    FIXED_HEADER_BYTES, PLAIN_BYTES,
    ktx2_blob::{self, Compress, Shape},
    levels,
    read::ReadError,
};
use crate::codec::{
    blocks::BlockFormat,
    image::{ColorSpace, Content, WaveletImage},
    plain::PlainTexture,
};

/// A plain texture with the number of mip levels in its file, and the first of them that it has.
pub(super) struct Contents {
    pub(super) levels: u32,
    pub(super) first: u32,
    pub(super) texture: PlainTexture,
}

/// The entry in the header, and the blob.
pub(super) fn write(
    image: &WaveletImage,
    texture: &PlainTexture,
    compress: Option<&Compress>,
) -> Vec<u8> {
    let is_srgb = texture.is_srgb(image.content, image.color_space, image.size);
    let shape = Shape::plain(texture.format, texture.size, is_srgb);
    let blob = ktx2_blob::write(shape, image.levels, &[], &texture.blocks, compress);
    let mut formats = BlockFormat::ALL.iter();
    let format = formats.position(|f| *f == texture.format);
    let mut bytes = vec![format.expect("ALL has all") as u8, 0, 0, 0];
    let [width, height] = texture.size;
    for field in [width, height, blob.len() as u32] {
        bytes.extend(field.to_le_bytes());
    }
    bytes.extend(blob);
    bytes
}

/// Reads them from a whole file.
pub(super) fn read(
    bytes: &[u8],
    content: Content,
    color_space: ColorSpace,
    image_size: [u32; 2],
    is_zstd: bool,
    max_size: Option<u32>,
) -> Result<Contents, ReadError> {
    let truncated = |part, needed: u64| ReadError::Truncated {
        part,
        needed,
        available: bytes.len(),
    };
    let start = FIXED_HEADER_BYTES + PLAIN_BYTES;
    let entry = bytes
        .get(FIXED_HEADER_BYTES..start)
        .ok_or_else(|| truncated("header", start as u64))?;
    let field = |field, value: u32| ReadError::Field { field, value };
    let format = BlockFormat::ALL.get(entry[0] as usize).copied();
    let format = format.filter(|format| PlainTexture::formats(content).contains(format));
    let format = format.ok_or_else(|| field("format", entry[0].into()))?;
    if let Some(reserved) = entry[1..4].iter().find(|b| **b != 0) {
        return Err(field("reserved byte", u32::from(*reserved)));
    }
    let u32_at = |at: usize| u32::from_le_bytes([0, 1, 2, 3].map(|i| entry[at + i]));
    let size = [u32_at(4), u32_at(8)];
    if !PlainTexture::is_valid_size(size, image_size) {
        let wrong = |axis: usize| {
            let [texels, pixels] = [size, image_size].map(|s| s[axis]);
            !PlainTexture::is_valid_size([texels; 2], [pixels; 2])
        };
        return Err(if wrong(0) {
            field("texture width", size[0])
        } else {
            field("texture height", size[1])
        });
    }
    let blob = &bytes[start..];
    let length = u32_at(12);
    let end = start as u64 + u64::from(length);
    if end > bytes.len() as u64 {
        return Err(truncated("plain texture", end));
    }
    if end < bytes.len() as u64 {
        return Err(ReadError::TrailingBytes(bytes.len() - end as usize));
    }
    let mut texture = PlainTexture {
        format,
        size,
        blocks: Vec::new(),
    };
    let is_srgb = texture.is_srgb(content, color_space, image_size);
    let shape = Shape::plain(format, size, is_srgb).with_zstd(is_zstd);
    let most = PlainTexture::max_level_count(size, image_size);
    let first_of = |levels| {
        let first = levels::first_level(image_size, levels, max_size);
        levels::first_of_plain(&texture, image_size, first)
    };
    let contents = ktx2_blob::read(blob, shape, most, first_of).map_err(ReadError::PlainBlob)?;
    let levels = contents.levels;
    let first = first_of(levels);
    texture.blocks = contents.blocks;
    if first > 0 {
        levels::begin_plain(&mut texture, image_size, first, levels);
    }
    Ok(Contents {
        levels,
        first,
        texture,
    })
}

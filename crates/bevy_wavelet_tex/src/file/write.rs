//! Writing a `.wtex` file, and the fingerprint of what it was made of.

#[cfg(feature = "zstd_encode")]
use super::zstd;
use super::{
    FINGERPRINT_FLAG, FLAGS_AT, MAGIC, PLAIN_VERSION, PLANES_VERSION, VERSION, ZSTD_FLAG,
    ktx2_blob::{self, Compress, Shape},
};
use crate::codec::{
    image::{ColorSpace, Content, Payload, WaveletImage},
    plain::PlainTexture,
};

const FINGERPRINT_BYTES: usize = size_of::<u64>();

/// The version of the file that [`write()`] makes of an image.
pub fn version(image: &WaveletImage) -> u16 {
    match &image.payload {
        Payload::Plain(_) => PLAIN_VERSION,
        Payload::Wavelet(planes) if planes.chroma.is_some() && !planes.axes.are_ycocg() => VERSION,
        Payload::Wavelet(_) => PLANES_VERSION,
    }
}

/// Returns the bytes of a file; [`super::read`] reads the same image from them.
pub fn write(image: &WaveletImage) -> Vec<u8> {
    written(image, None)
}

/// Returns the bytes of a file whose levels are compressed with Zstandard, at a `level` from 1 (fast) to
/// 22 (small). Reading such a file needs the feature `zstd`.
#[cfg(feature = "zstd_encode")]
pub fn write_zstd(image: &WaveletImage, level: i32) -> Vec<u8> {
    written(image, Some(&|bytes| zstd::compress(bytes, level)))
}

fn written(image: &WaveletImage, compress: Option<&Compress>) -> Vec<u8> {
    let content = match image.content {
        Content::Gray => 0,
        Content::Color => 1,
        Content::Normal => 2,
        Content::ColorAlpha => 3,
    };
    let color_space = match image.color_space {
        ColorSpace::Linear => 0,
        ColorSpace::Srgb => 1,
    };
    let mut bytes = MAGIC.to_vec();
    let flags = if compress.is_some() { ZSTD_FLAG } else { 0 };
    bytes.extend([version(image) as u8, flags, content, color_space]);
    bytes.extend(image.size.iter().flat_map(|s| s.to_le_bytes()));
    bytes.extend((image.groups().count() as u32).to_le_bytes());
    let planes = match &image.payload {
        Payload::Wavelet(planes) => planes,
        Payload::Plain(texture) => {
            bytes.extend(plain_texture(image, texture, compress));
            return bytes;
        }
    };
    if version(image) == VERSION {
        let entries = planes.axes.rgb.as_flattened();
        bytes.extend(entries.iter().flat_map(|v| v.to_le_bytes()));
    }
    let mut blobs = Vec::new();
    for group in planes.groups() {
        bytes.extend([group.subsampling as u8, group.packing as u8, 0, 0]);
        let mut lengths = [0u32; 2];
        for (texture, length) in lengths.iter_mut().enumerate().take(group.textures.len()) {
            let shape = Shape::of_group(group, texture, image.size, group.codings.len());
            let blocks = &group.textures[texture];
            let blob = ktx2_blob::write(shape, image.levels, &group.codings, blocks, compress);
            *length = blob.len() as u32;
            blobs.extend(blob);
        }
        bytes.extend(lengths.iter().flat_map(|l| l.to_le_bytes()));
    }
    bytes.extend(blobs);
    bytes
}

/// The entry of a plain texture in the header, and the blob.
fn plain_texture(
    image: &WaveletImage,
    texture: &PlainTexture,
    compress: Option<&Compress>,
) -> Vec<u8> {
    let is_srgb = texture.is_srgb(image.content, image.color_space, image.size);
    let shape = Shape::plain(texture.format, texture.size, is_srgb);
    let blob = ktx2_blob::write(shape, image.levels, &[], &texture.blocks, compress);
    let mut bytes = vec![texture.format as u8, 0, 0, 0];
    let [width, height] = texture.size;
    for field in [width, height, blob.len() as u32] {
        bytes.extend(field.to_le_bytes());
    }
    bytes.extend(blob);
    bytes
}

/// Adds a fingerprint to the bytes of a file, or replaces the one that is there.
pub fn with_fingerprint(mut bytes: Vec<u8>, value: u64) -> Vec<u8> {
    bytes.truncate(without_fingerprint(&bytes).len());
    bytes[FLAGS_AT] |= FINGERPRINT_FLAG;
    bytes.extend(value.to_le_bytes());
    bytes
}

/// The fingerprint of a file that has one.
pub fn fingerprint(bytes: &[u8]) -> Option<u64> {
    let end = without_fingerprint(bytes).len();
    bytes[end..]
        .first_chunk()
        .map(|value| u64::from_le_bytes(*value))
}

/// The file without its fingerprint.
pub(super) fn without_fingerprint(bytes: &[u8]) -> &[u8] {
    let has_one = bytes.starts_with(&MAGIC)
        && bytes
            .get(FLAGS_AT)
            .is_some_and(|flags| flags & FINGERPRINT_FLAG != 0)
        && bytes.len() >= MAGIC.len() + FINGERPRINT_BYTES;
    let end = if has_one {
        bytes.len() - FINGERPRINT_BYTES
    } else {
        bytes.len()
    };
    &bytes[..end]
}

//! Writing a `.wtex` file.

#[cfg(feature = "zstd_encode")]
use super::zstd;
use super::{
    MAGIC, PLAIN_VERSION, PLANES_VERSION, VERSION, ZSTD_FLAG,
    ktx2_blob::{self, Compress},
    plain,
};
use crate::codec::{
    image::{ColorSpace, Content, WaveletImage},
    packing::Packing,
};

/// The version of the file that [`write()`] makes of an image.
pub fn version(image: &WaveletImage) -> u16 {
    if image.plain.is_some() {
        PLAIN_VERSION
    } else if image.content.has_chroma() && !image.axes.are_ycocg() {
        VERSION
    } else {
        PLANES_VERSION
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
    bytes.extend((image.groups.len() as u32).to_le_bytes());
    if let Some(texture) = &image.plain {
        bytes.extend(plain::write(image, texture, compress));
        return bytes;
    }
    if version(image) == VERSION {
        let entries = image.axes.rgb.as_flattened();
        bytes.extend(entries.iter().flat_map(|v| v.to_le_bytes()));
    }
    let mut blobs = Vec::new();
    for group in &image.groups {
        let packing = Packing::ALL.iter().position(|p| *p == group.packing);
        let packing = packing.expect("ALL has all") as u8;
        bytes.extend([group.subsampling as u8, packing, 0, 0]);
        let mut lengths = [0u32; 2];
        for (texture, length) in lengths.iter_mut().enumerate().take(group.textures.len()) {
            let shape = ktx2_blob::Shape::of_group(
                group.packing.formats()[texture],
                image.size,
                group.subsampling,
                group.packing,
                group.codings.len(),
            );
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

//! Writing a `.wtex` file.

use super::{MAGIC, VERSION, ktx2_blob};
use crate::codec::image::{ColorSpace, Content, WaveletImage};

/// The bytes of a file; [`super::read`] gives the same image back.
pub fn write(image: &WaveletImage) -> Vec<u8> {
    let content = match image.content {
        Content::Gray => 0,
        Content::Color => 1,
        Content::Normal => 2,
    };
    let color_space = match image.color_space {
        ColorSpace::Linear => 0,
        ColorSpace::Srgb => 1,
    };
    let blobs: Vec<Vec<u8>> = (0..image.groups.len())
        .map(|group| ktx2_blob::write(image, group))
        .collect();

    let mut bytes = MAGIC.to_vec();
    bytes.extend(VERSION.to_le_bytes());
    bytes.extend([content, color_space]);
    bytes.extend(image.size.iter().flat_map(|s| s.to_le_bytes()));
    bytes.extend((blobs.len() as u32).to_le_bytes());
    bytes.extend(
        blobs
            .iter()
            .flat_map(|blob| (blob.len() as u32).to_le_bytes()),
    );
    bytes.extend(blobs.iter().flatten());
    bytes
}

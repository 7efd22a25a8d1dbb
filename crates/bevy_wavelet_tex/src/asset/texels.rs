//! The pixels of Bevy's images as the input of the encoder.

use bevy::{image::Image, render::render_resource::TextureFormat};

use crate::codec::{
    angle::normal_blue,
    image::Content,
    layout,
    source::{Pixels, Source},
};

/// The texels of an image, all levels one after the other.
pub(super) enum Texels<'a> {
    Gray8(&'a [u8]),
    Rgba8(&'a [[u8; 4]]),
    Rgb8(Vec<[u8; 3]>),
    Gray16(Vec<u16>),
    Rgba16(Vec<[u16; 4]>),
}

impl Texels<'_> {
    pub(super) fn first(&self) -> Pixels<'_> {
        self.range(0, usize::MAX)
    }

    fn range(&self, start: usize, length: usize) -> Pixels<'_> {
        fn part<T>(all: &[T], start: usize, length: usize) -> &[T] {
            let end = start.saturating_add(length).min(all.len());
            &all[start.min(end)..end]
        }
        match self {
            Self::Gray8(texels) => Pixels::Gray8(part(texels, start, length)),
            Self::Rgba8(texels) => Pixels::Rgba8(part(texels, start, length)),
            Self::Rgb8(texels) => Pixels::Rgb8(part(texels, start, length)),
            Self::Gray16(texels) => Pixels::Gray16(part(texels, start, length)),
            Self::Rgba16(texels) => Pixels::Rgba16(part(texels, start, length)),
        }
    }

    /// Splits the texels into the levels that the image has.
    pub(super) fn source(&self, size: [u32; 2]) -> Source<'_> {
        let all = self.first().len();
        let mut levels = Vec::new();
        let mut start = 0;
        while start < all {
            let [width, height] = layout::mip_size(size, levels.len() as u32);
            let length = width as usize * height as usize;
            levels.push(self.range(start, length));
            start += length;
        }
        Source { size, levels }
    }
}

/// The texels of an image: `None` where it is not two-dimensional or has no pixels in main memory,
/// and its format as an error where that is not supported.
pub(super) fn texels(image: &Image, content: Content) -> Option<Result<Texels<'_>, TextureFormat>> {
    let data = image.data.as_deref()?;
    if image.texture_descriptor.size.depth_or_array_layers != 1 {
        return None;
    }
    let words = || {
        let (pairs, _) = data.as_chunks::<2>();
        pairs.iter().map(|pair| u16::from_le_bytes(*pair))
    };
    Some(Ok(match image.texture_descriptor.format {
        TextureFormat::R8Unorm => Texels::Gray8(data),
        TextureFormat::Rgba8Unorm | TextureFormat::Rgba8UnormSrgb => {
            Texels::Rgba8(data.as_chunks::<4>().0)
        }
        TextureFormat::Rg8Unorm => {
            let (pairs, _) = data.as_chunks::<2>();
            Texels::Rgb8(pairs.iter().map(|pair| with_blue(*pair, content)).collect())
        }
        TextureFormat::R16Unorm => Texels::Gray16(words().collect()),
        TextureFormat::Rgba16Unorm => {
            let words: Vec<u16> = words().collect();
            Texels::Rgba16(words.as_chunks::<4>().0.to_vec())
        }
        other => return Some(Err(other)),
    }))
}

/// Adds the blue of two channels: of normals the Z of a unit vector, of others 0.
fn with_blue([r, g]: [u8; 2], content: Content) -> [u8; 3] {
    match content {
        Content::Normal => [r, g, normal_blue([r, g])],
        _ => [r, g, 0],
    }
}

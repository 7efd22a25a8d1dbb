//! The reference decoder (thesis section 3.5.3), which computes what the shader computes.

use rayon::prelude::*;

use super::{
    blocks::{BlockFormat, Texel, decode_blocks},
    chroma::interpolated,
    color::{YCoCg, rgb_from_ycocg},
    image::{Content, PlaneGroup, WaveletImage},
    layout,
    packing::Packing,
    plain::read,
    plane::Plane,
    wavelet::decode_plane,
};

/// A decoded image: colour, gray repeated in three channels, or X, Y and Z of normals.
#[derive(Clone, Debug, PartialEq)]
pub struct DecodedImage {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Values in `[0, 1]` (of normals in `[-1, 1]`), row by row from the top, in the colour space
    /// of the wavelet image.
    pub pixels: Vec<[f32; 3]>,
    /// Alpha in `[0, 1]`, or `None` where the image has none.
    pub alpha: Option<Vec<f32>>,
}

impl DecodedImage {
    /// Converts the pixels to 8 bits a channel. Alpha is 255 where there is none, and normals are
    /// mapped from `[-1, 1]` to `[0, 255]`.
    pub fn to_rgba8(&self, content: Content) -> Vec<Texel> {
        let unit = |v: f32| {
            if content == Content::Normal {
                0.5 + 0.5 * v
            } else {
                v
            }
        };
        // `f32::round` would be a call of a library.
        let byte = |v: f32| (v.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
        let alpha = |i: usize| self.alpha.as_ref().map_or(255, |alpha| byte(alpha[i]));
        let pixels = self.pixels.par_iter().enumerate();
        pixels
            .map(|(i, v)| {
                let [r, g, b] = v.map(|v| byte(unit(v)));
                [r, g, b, alpha(i)]
            })
            .collect()
    }
}

/// Decodes one mip level.
///
/// # Panics
/// Panics when `level` is not below `image.levels`, or when the blocks are not as long as the sizes
/// require. The file reader and the encoder return only images for which they are.
pub fn decode(image: &WaveletImage, level: u32) -> DecodedImage {
    decode_with(image, level, decode_blocks)
}

/// Decodes one mip level with another block decoder, such as a driver's, instead of
/// [`decode_blocks`].
///
/// # Panics
/// Panics as [`decode`] does.
pub fn decode_with(
    image: &WaveletImage,
    level: u32,
    decode_blocks: impl Fn(BlockFormat, &[u8], [u32; 2]) -> Vec<[f32; 4]>,
) -> DecodedImage {
    if let Some(plain) = &image.plain {
        return from_channels(
            image,
            level,
            read::pixels(plain, image.size, level, decode_blocks),
        );
    }
    let size = layout::mip_size(image.size, level);
    let groups: Vec<Vec<Plane>> = (0..image.groups.len())
        .map(|group| decode_group(image, group, level, &decode_blocks))
        .collect();
    let luma = &groups[0];
    let chroma: Vec<Plane> = image.groups[1..]
        .iter()
        .zip(&groups[1..])
        .flat_map(|(group, planes)| planes.iter().map(|plane| at_pixels(group, plane, size)))
        .collect();
    let unit = |v: f32| v.clamp(0.0, 1.0);
    let pixel = |i: usize| match image.content {
        Content::Gray => [unit(luma[0].values[i]); 3],
        Content::Color | Content::ColorAlpha => {
            let [y, co, cg] = [&luma[0], &chroma[0], &chroma[1]].map(|p| p.values[i]);
            let rgb = if image.axes.are_ycocg() {
                rgb_from_ycocg(YCoCg { y, co, cg })
            } else {
                image.axes.rgb_of([y, co, cg])
            };
            rgb.map(unit)
        }
        Content::Normal => normal_from_xy([0, 1].map(|plane: usize| luma[plane].values[i])),
    };
    DecodedImage {
        size,
        pixels: (0..luma[0].values.len())
            .into_par_iter()
            .map(pixel)
            .collect(),
        alpha: (image.content == Content::ColorAlpha)
            .then(|| luma[1].values.iter().copied().map(unit).collect()),
    }
}

/// A plane of chroma at the pixels of a level of `size`.
fn at_pixels(group: &PlaneGroup, plane: &Plane, size: [u32; 2]) -> Plane {
    let subsampling = group.subsampling;
    if group.packing == Packing::Bc1 {
        interpolated(plane, subsampling, size)
    } else {
        Plane::from_fn(size, |x, y| {
            plane.clamped(x >> subsampling, y >> subsampling)
        })
    }
}

/// The image of the channels of a plain texture.
fn from_channels(image: &WaveletImage, level: u32, channels: Vec<[f32; 4]>) -> DecodedImage {
    let pixel = |[r, g, b, _]: &[f32; 4]| match image.content {
        Content::Gray => [*r; 3],
        Content::Color | Content::ColorAlpha => [*r, *g, *b],
        Content::Normal => normal_from_xy([2.0 * r - 1.0, 2.0 * g - 1.0]),
    };
    DecodedImage {
        size: layout::mip_size(image.size, level),
        pixels: channels.iter().map(pixel).collect(),
        alpha: (image.content == Content::ColorAlpha)
            .then(|| channels.iter().map(|v| v[3]).collect()),
    }
}

/// The unit normal with these X and Y. Vectors outside of the unit circle are shortened to it.
pub fn normal_from_xy([x, y]: [f32; 2]) -> [f32; 3] {
    let length_squared = x * x + y * y;
    let scale = 1.0 / length_squared.max(1.0).sqrt();
    [x * scale, y * scale, (1.0 - length_squared).max(0.0).sqrt()]
}

/// What a texel of [`Packing::Bc1`] holds of a plane.
pub(super) fn stored_chroma(plane: usize, [r, g, b, _]: [f32; 4]) -> f32 {
    [0.5 * (r + b), g][plane]
}

fn decode_group(
    image: &WaveletImage,
    index: usize,
    level: u32,
    decode: &impl Fn(BlockFormat, &[u8], [u32; 2]) -> Vec<[f32; 4]>,
) -> Vec<Plane> {
    let group = &image.groups[index];
    let size = group.plane_size(image.size, level);
    let texture = group.texture_level_size(image.size, level);
    if group.packing == Packing::Bc1 {
        let blocks = image.level_blocks(index, 0, level, 0);
        let texels = decode(BlockFormat::Bc1, blocks, texture);
        let planes = group.codings.iter().enumerate();
        return planes
            .map(|(plane, coding)| {
                Plane::from_fn(size, |x, y| {
                    let texel = texels[(y * texture[0] + x) as usize];
                    coding.load_low(stored_chroma(plane, texel))
                })
            })
            .collect();
    }
    let layers = group.codings.iter().enumerate();
    layers
        .map(|(layer, coding)| {
            let blocks: Vec<&[u8]> = (0..group.textures.len())
                .map(|texture| image.level_blocks(index, texture, level, layer))
                .collect();
            decode_plane(group.packing, coding, &blocks, texture, size, decode)
        })
        .collect()
}

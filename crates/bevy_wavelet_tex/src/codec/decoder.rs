//! The reference decoder (thesis section 3.5.3): what the shader computes, one texel at a time.

use super::{
    blocks::{Texel, decode_bc3},
    color::{YCoCg, rgb_from_ycocg},
    haar::{Coefficients, inverse_haar},
    image::{Content, WaveletImage},
    layout,
    plane::Plane,
    quantizer::PlaneCoding,
};

/// A decoded image, RGBA: the colour, gray in all three, or X, Y, Z of normals in `[-1, 1]`.
#[derive(Clone, Debug, PartialEq)]
pub struct DecodedImage {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// `[0, 1]` (normals `[-1, 1]`), row by row, in the colour space of the wavelet image.
    pub pixels: Vec<[f32; 3]>,
}

impl DecodedImage {
    /// 8 bits a channel, alpha 255; normals mapped from `[-1, 1]` to `[0, 255]`.
    pub fn to_rgba8(&self, content: Content) -> Vec<Texel> {
        let unit = |v: f32| {
            if content == Content::Normal {
                0.5 + 0.5 * v
            } else {
                v
            }
        };
        let byte = |v: f32| (unit(v).clamp(0.0, 1.0) * 255.0).round() as u8;
        self.pixels
            .iter()
            .map(|&[r, g, b]| [byte(r), byte(g), byte(b), 255])
            .collect()
    }
}

/// Decodes one mip level.
///
/// # Panics
/// When `level` is not below `image.levels`, or the blocks are not as long as the sizes say; the
/// file reader and the encoder only make images that are.
pub fn decode(image: &WaveletImage, level: u32) -> DecodedImage {
    decode_with(image, level, decode_bc3)
}

/// Decodes one mip level with another decoder of BC3 blocks, such as a driver's, in the place of
/// [`decode_bc3`].
///
/// # Panics
/// As [`decode`].
pub fn decode_with(
    image: &WaveletImage,
    level: u32,
    decode_blocks: impl Fn(&[u8], [u32; 2]) -> Vec<[f32; 4]>,
) -> DecodedImage {
    let size = layout::mip_size(image.size, level);
    let planes: Vec<Vec<Plane>> = (0..image.groups.len())
        .map(|group| {
            let layers = 0..image.groups[group].codings.len();
            layers
                .map(|layer| decode_plane(image, group, level, layer, &decode_blocks))
                .collect()
        })
        .collect();
    let pixel = |x: u32, y: u32| match image.content {
        Content::Gray => [planes[0][0].clamped(x, y).clamp(0.0, 1.0); 3],
        Content::Color => {
            let [co, cg] = [0, 1].map(|i| planes[1][i].clamped(x / 2, y / 2));
            let rgb = rgb_from_ycocg(YCoCg {
                y: planes[0][0].clamped(x, y),
                co,
                cg,
            });
            rgb.map(|v| v.clamp(0.0, 1.0))
        }
        Content::Normal => normal_from_xy([0, 1].map(|i| planes[0][i].clamped(x, y))),
    };
    let pixels = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y)));
    DecodedImage {
        size,
        pixels: pixels.map(|(x, y)| pixel(x, y)).collect(),
    }
}

/// The unit normal whose X and Y these are; shortened to the unit circle where longer.
pub fn normal_from_xy([x, y]: [f32; 2]) -> [f32; 3] {
    let length_squared = x * x + y * y;
    let scale = 1.0 / length_squared.max(1.0).sqrt();
    [x * scale, y * scale, (1.0 - length_squared).max(0.0).sqrt()]
}

fn decode_plane(
    image: &WaveletImage,
    group: usize,
    level: u32,
    layer: usize,
    decode_blocks: impl Fn(&[u8], [u32; 2]) -> Vec<[f32; 4]>,
) -> Plane {
    let shape = image.content.groups()[group];
    let plane_size = layout::plane_size(layout::mip_size(image.size, level), shape.subsampling);
    let texture_size = layout::mip_size(image.texture_size(group), level);
    let texels = decode_blocks(image.level_blocks(group, level, layer), texture_size);
    let coding = &image.groups[group].codings[layer];
    Plane::from_fn(plane_size, |x, y| {
        let texel = texels[(y / 2 * texture_size[0] + x / 2) as usize];
        inverse_haar(load_texel(coding, texel))[(y % 2 * 2 + x % 2) as usize]
    })
}

/// The coefficients that a texel stores.
pub fn load_texel(coding: &PlaneCoding, [r, g, b, a]: [f32; 4]) -> Coefficients {
    Coefficients {
        ll: 2.0 * coding.load_mean(a),
        details: coding.load_details([r, g, b]),
    }
}

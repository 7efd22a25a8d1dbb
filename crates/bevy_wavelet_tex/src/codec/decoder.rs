//! The reference decoder (thesis section 3.5.3), which computes what the shader computes.

use rayon::prelude::*;

use super::{
    axes::ColorAxes,
    blocks::{BlockFormat, Texel, decode_blocks},
    chroma,
    color::{YCoCg, rgb_from_ycocg},
    image::{Content, Payload, PlaneGroup, WaveletImage},
    interpolation::Interpolation,
    layout,
    packing::Packing,
    plain::PlainRows,
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
    let rows = LevelRows::new(image, level, decode_blocks);
    let size = rows.size;
    let width = size[0] as usize;
    let has_alpha = image.content == Content::ColorAlpha;
    let mut pixels = vec![[0.0; 3]; width * size[1] as usize];
    let mut alpha = vec![0.0; if has_alpha { pixels.len() } else { 0 }];
    let fill = |row: &mut Vec<[f32; 4]>, y: usize, pixels: &mut [[f32; 3]]| {
        rows.fill(y as u32, row);
        for (pixel, [r, g, b, _]) in pixels.iter_mut().zip(row) {
            *pixel = [*r, *g, *b];
        }
    };
    let row = || vec![[0.0; 4]; width];
    let lines = pixels.par_chunks_mut(width).enumerate();
    if has_alpha {
        let lines = lines.zip(alpha.par_chunks_mut(width));
        lines.for_each_init(row, |row, ((y, pixels), alpha)| {
            fill(row, y, pixels);
            for (alpha, [.., a]) in alpha.iter_mut().zip(row) {
                *alpha = *a;
            }
        });
    } else {
        lines.for_each_init(row, |row, (y, pixels)| fill(row, y, pixels));
    }
    DecodedImage {
        size,
        pixels,
        alpha: has_alpha.then_some(alpha),
    }
}

/// A level whose pixels are put together row by row, since all of them would take several times the memory of its
/// planes.
pub(super) struct LevelRows {
    content: Content,
    pub(super) size: [u32; 2],
    planes: Planes,
}

enum Planes {
    Plain(PlainRows),
    Wavelet {
        axes: ColorAxes,
        luma: Vec<Plane>,
        /// Chroma at its own size.
        chroma: Vec<Plane>,
        subsampling: u32,
        /// That of chroma, whose values are repeated where there is none.
        interpolation: Option<Interpolation>,
    },
}

impl LevelRows {
    pub(super) fn new(
        image: &WaveletImage,
        level: u32,
        decode_blocks: impl Fn(BlockFormat, &[u8], [u32; 2]) -> Vec<[f32; 4]>,
    ) -> Self {
        let size = layout::mip_size(image.size, level);
        let planes = match &image.payload {
            Payload::Plain(plain) => {
                Planes::Plain(PlainRows::new(plain, image.size, level, decode_blocks))
            }
            Payload::Wavelet(planes) => {
                let decoded = |group| decode_group(group, image.size, level, &decode_blocks);
                let chroma = planes.chroma.as_ref();
                let subsampling = chroma.map_or(0, |group| group.subsampling);
                let is_interpolated = chroma.is_some_and(|group| group.packing == Packing::Bc1);
                Planes::Wavelet {
                    axes: planes.axes,
                    luma: decoded(&planes.luma),
                    chroma: chroma.map(decoded).unwrap_or_default(),
                    subsampling,
                    interpolation: is_interpolated
                        .then(|| Interpolation::new(chroma::axes(size, subsampling))),
                }
            }
        };
        Self {
            content: image.content,
            size,
            planes,
        }
    }

    /// RGBA of a row of pixels. Alpha is 1 where there is none.
    pub(super) fn fill(&self, y: u32, row: &mut [[f32; 4]]) {
        match &self.planes {
            Planes::Plain(rows) => {
                rows.fill(y, row);
                for pixel in row {
                    *pixel = self.content.of_channels(*pixel);
                }
            }
            Planes::Wavelet {
                axes,
                luma,
                chroma,
                subsampling,
                interpolation,
            } => {
                let width = self.size[0] as usize;
                let line =
                    |plane: &Plane| y as usize * width..y as usize * width + plane.size[0] as usize;
                let luma: Vec<&[f32]> = luma.iter().map(|p| &p.values[line(p)]).collect();
                let chroma = chroma.iter().map(|plane| {
                    let mut values = vec![0.0; width];
                    if let Some(interpolation) = interpolation {
                        interpolation.fill(plane, y, &mut values);
                    } else {
                        for (x, value) in values.iter_mut().enumerate() {
                            let [x, y] = [x as u32, y].map(|p| p >> subsampling);
                            *value = plane.clamped(x, y);
                        }
                    }
                    values
                });
                let chroma: Vec<Vec<f32>> = chroma.collect();
                for (x, pixel) in row.iter_mut().enumerate() {
                    *pixel = self.of_planes(axes, x, &luma, &chroma);
                }
            }
        }
    }

    /// A pixel of the planes of a wavelet.
    fn of_planes(
        &self,
        axes: &ColorAxes,
        x: usize,
        luma: &[&[f32]],
        chroma: &[Vec<f32>],
    ) -> [f32; 4] {
        let unit = |v: f32| v.clamp(0.0, 1.0);
        let [r, g, b] = match self.content {
            Content::Gray => [unit(luma[0][x]); 3],
            Content::Color | Content::ColorAlpha => {
                let [y, co, cg] = [luma[0][x], chroma[0][x], chroma[1][x]];
                let rgb = if axes.are_ycocg() {
                    rgb_from_ycocg(YCoCg { y, co, cg })
                } else {
                    axes.rgb_of([y, co, cg])
                };
                rgb.map(unit)
            }
            Content::Normal => normal_from_xy([luma[0][x], luma[1][x]]),
        };
        let alpha = match self.content {
            Content::ColorAlpha => unit(luma[1][x]),
            _ => 1.0,
        };
        [r, g, b, alpha]
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
    group: &PlaneGroup,
    image_size: [u32; 2],
    level: u32,
    decode: &impl Fn(BlockFormat, &[u8], [u32; 2]) -> Vec<[f32; 4]>,
) -> Vec<Plane> {
    let size = group.plane_size(image_size, level);
    let texture = group.texture_level_size(image_size, level);
    if group.packing == Packing::Bc1 {
        let blocks = group.level_blocks(image_size, 0, level, 0);
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
                .map(|texture| group.level_blocks(image_size, texture, level, layer))
                .collect();
            decode_plane(group.packing, coding, &blocks, texture, size, decode)
        })
        .collect()
}

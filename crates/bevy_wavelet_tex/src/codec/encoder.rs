//! The encoder: from 8-bit pixels to a [`WaveletImage`].

use rayon::prelude::*;
use thiserror::Error;

use super::{
    blocks::{BlockQuality, Texel, encode_bc3},
    color::{linear_from_srgb, srgb_from_linear, ycocg_from_rgb},
    decoder::normal_from_xy,
    haar::{Coefficients, haar},
    image::{ColorSpace, Content, PlaneGroup, WaveletImage},
    layout,
    plane::Plane,
    quantizer::PlaneCoding,
    search::{Effort, choose_coding},
};

/// How to encode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EncodeSettings {
    /// What the pixels hold. Default: colour.
    pub content: Content,
    /// How they relate to light. Default: sRGB.
    pub color_space: ColorSpace,
    /// Whether to make mips (a box filter in linear light; normals renormalised). Default: yes.
    pub mips: bool,
    /// How hard to search for the parameters. Default: [`Effort::Default`].
    pub effort: Effort,
}

impl Default for EncodeSettings {
    fn default() -> Self {
        Self {
            content: Content::Color,
            color_space: ColorSpace::Srgb,
            mips: true,
            effort: Effort::Default,
        }
    }
}

/// Why an image cannot be encoded.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum EncodeError {
    /// A side is 0 or larger than [`layout::MAX_SIZE`].
    #[error("an image of {} x {} pixels cannot be encoded: both sides must be 1 to {}", .0[0], .0[1], layout::MAX_SIZE)]
    Size([u32; 2]),
    /// The pixels are not as many as the size says.
    #[error("an image of {} x {} pixels has {pixels} pixels of data", .size[0], .size[1])]
    PixelCount {
        /// Width and height in pixels.
        size: [u32; 2],
        /// Pixels given.
        pixels: usize,
    },
}

/// Encodes RGB pixels, row by row from the top.
///
/// Gray takes the luma of YCoCg, as the thesis does; normals take X and Y from R and G. The result
/// does not depend on the number of threads. `progress` hears of each finished part and of how many
/// there are.
///
/// # Errors
/// When the size is out of range or does not fit the pixels.
pub fn encode(
    pixels: &[[u8; 3]],
    size: [u32; 2],
    settings: &EncodeSettings,
    progress: &(dyn Fn(usize, usize) + Sync),
) -> Result<WaveletImage, EncodeError> {
    if size.iter().any(|s| !(1..=layout::MAX_SIZE).contains(s)) {
        return Err(EncodeError::Size(size));
    }
    if pixels.len() as u64 != u64::from(size[0]) * u64::from(size[1]) {
        return Err(EncodeError::PixelCount {
            size,
            pixels: pixels.len(),
        });
    }
    let content = settings.content;
    let subsamplings: Vec<u32> = content.groups().iter().map(|g| g.subsampling).collect();
    let levels = if settings.mips {
        layout::max_level_count(size, &subsamplings)
    } else {
        1
    };
    let parts = levels as usize * content.groups().iter().map(|g| g.planes).sum::<usize>();
    let done = std::sync::atomic::AtomicUsize::new(0);
    let report = || {
        let done = done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1;
        progress(done, parts);
    };

    let mips = mip_planes(pixels, size, settings, levels);
    let groups = content.groups().iter().scan(0, |first_plane, shape| {
        let planes = *first_plane..*first_plane + shape.planes;
        *first_plane = planes.end;
        Some((shape, planes))
    });
    let groups = groups
        .map(|(shape, planes)| {
            let coefficients = |level: usize, plane: usize| {
                let plane = &mips[level][plane];
                let halved = (0..shape.subsampling).fold(plane.clone(), |p, _| p.halved());
                CoefficientPlane::from_plane(&halved)
            };
            let codings: Vec<PlaneCoding> = planes
                .clone()
                .map(|plane| choose_coding(&coefficients(0, plane), settings.effort))
                .collect();
            let texture = layout::texture_size(layout::plane_size(size, shape.subsampling));
            let blocks: Vec<Vec<u8>> = (0..levels as usize * shape.planes)
                .into_par_iter()
                .map(|part| {
                    let (level, layer) = (part / shape.planes, part % shape.planes);
                    let texture = layout::mip_size(texture, level as u32);
                    let texels =
                        coefficients(level, planes.start + layer).texels(&codings[layer], texture);
                    let quality = settings.effort.block_quality();
                    let blocks = encode_bc3(&texels, texture, quality);
                    report();
                    blocks
                })
                .collect();
            PlaneGroup {
                codings,
                blocks: blocks.concat(),
            }
        })
        .collect();
    Ok(WaveletImage {
        content,
        color_space: settings.color_space,
        size,
        levels,
        groups,
    })
}

/// The planes of all mip levels, at the size of the image.
fn mip_planes(
    pixels: &[[u8; 3]],
    size: [u32; 2],
    settings: &EncodeSettings,
    levels: u32,
) -> Vec<Vec<Plane>> {
    let normal = settings.content == Content::Normal;
    let srgb = settings.color_space == ColorSpace::Srgb && !normal;
    let channel = |i: usize| Plane {
        size,
        values: pixels.iter().map(|p| f32::from(p[i]) / 255.0).collect(),
    };
    let level_0 = [0, 1, 2].map(channel);
    let map = |planes: &[Plane; 3], f: fn(f32) -> f32| {
        planes.clone().map(|mut p| {
            p.values.iter_mut().for_each(|v| *v = f(*v));
            p
        })
    };
    // Light adds up in linear units, normals as vectors.
    let mut filtered = if srgb {
        map(&level_0, linear_from_srgb)
    } else {
        level_0.clone()
    };
    let mut mips = vec![planes_of(&level_0, settings.content)];
    for _ in 1..levels {
        filtered = filtered.map(|plane| plane.next_mip());
        let encoded = if srgb {
            map(&filtered, srgb_from_linear)
        } else {
            filtered.clone()
        };
        mips.push(planes_of(&encoded, settings.content));
    }
    mips
}

/// The planes that a content is taken apart into, all at full size.
fn planes_of(channels: &[Plane; 3], content: Content) -> Vec<Plane> {
    let size = channels[0].size;
    let rgb = |i: usize| [0, 1, 2].map(|c: usize| channels[c].values[i]);
    let plane = |value: &dyn Fn(usize) -> f32| Plane {
        size,
        values: (0..channels[0].values.len()).map(value).collect(),
    };
    match content {
        Content::Gray => vec![plane(&|i| ycocg_from_rgb(rgb(i)).y)],
        Content::Color => vec![
            plane(&|i| ycocg_from_rgb(rgb(i)).y),
            plane(&|i| ycocg_from_rgb(rgb(i)).co),
            plane(&|i| ycocg_from_rgb(rgb(i)).cg),
        ],
        Content::Normal => {
            let unit = |i: usize| {
                let v = rgb(i).map(|v| 2.0 * v - 1.0);
                let length = v.iter().map(|v| v * v).sum::<f32>().sqrt();
                if length > 1e-6 {
                    v.map(|v| v / length)
                } else {
                    normal_from_xy([0.0, 0.0])
                }
            };
            vec![plane(&|i| unit(i)[0]), plane(&|i| unit(i)[1])]
        }
    }
}

/// The coefficients of one plane.
pub(super) struct CoefficientPlane {
    /// Coefficients in x and y.
    size: [u32; 2],
    /// Row by row.
    pub(super) coefficients: Vec<Coefficients>,
}

impl CoefficientPlane {
    pub(super) fn from_plane(plane: &Plane) -> Self {
        let size = layout::coefficient_size(plane.size);
        let positions = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y)));
        Self {
            size,
            coefficients: positions.map(|(x, y)| haar(plane.quad(x, y))).collect(),
        }
    }

    /// The stored texels, filled to the texture's size by repeating the edge.
    fn texels(&self, coding: &PlaneCoding, texture_size: [u32; 2]) -> Vec<Texel> {
        let positions = (0..texture_size[1])
            .flat_map(|y| (0..texture_size[0]).map(move |x| (x, y)))
            .map(|(x, y)| (x.min(self.size[0] - 1), y.min(self.size[1] - 1)));
        positions
            .map(|(x, y)| store_texel(coding, &self.coefficients[(y * self.size[0] + x) as usize]))
            .collect()
    }

    /// Evenly spread 4 x 4 blocks, at most `count`, as one image four texels high: enough to
    /// compare parameters by.
    pub(super) fn sample_blocks(&self, count: usize) -> Vec<Coefficients> {
        let [bw, bh] = self.size.map(|s| s.div_ceil(4));
        let total = bw as usize * bh as usize;
        let chosen = total.min(count);
        let blocks: Vec<usize> = (0..chosen).map(|i| i * total / chosen).collect();
        let mut sample = Vec::with_capacity(16 * chosen);
        for row in 0..4 {
            for &block in &blocks {
                for column in 0..4 {
                    let x = (block as u32 % bw * 4 + column).min(self.size[0] - 1);
                    let y = (block as u32 / bw * 4 + row).min(self.size[1] - 1);
                    sample.push(self.coefficients[(y * self.size[0] + x) as usize]);
                }
            }
        }
        sample
    }
}

/// The texel that stores the coefficients.
pub(super) fn store_texel(coding: &PlaneCoding, c: &Coefficients) -> Texel {
    let [r, g, b] = coding.store_details(c.details);
    [r, g, b, coding.store_mean(c.ll / 2.0)].map(|v| (v * 255.0).round() as u8)
}

impl Effort {
    fn block_quality(self) -> BlockQuality {
        match self {
            Self::Fast => BlockQuality::Normal,
            Self::Default | Self::Best => BlockQuality::High,
        }
    }
}

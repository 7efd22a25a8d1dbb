//! Conversion of one plane at one mip level to coefficients, to blocks, and back.

use rayon::prelude::*;

use super::{
    blocks::BlockFormat,
    haar::{Coefficients, Details, haar, inverse_haar},
    layout,
    packing::Packing,
    plane::Plane,
    predict::predicted,
    quantizer::PlaneCoding,
};

#[cfg(feature = "encode")]
use super::{
    blocks::{
        BlockQuality, DetailEncoder, Starts, Texel, decode_blocks, encode_bc3, encode_bc4,
        encode_bc7, with_alpha_blocks,
    },
    settings::Effort,
};

/// The low band and the detail bands of a plane.
#[derive(Clone, Debug)]
pub struct CoefficientPlane {
    /// The low band as LL / 2, which is the plane at half its size.
    pub low_band: Plane,
    /// HL, LH and HH of every 2 x 2 pixels, row by row.
    pub details: Vec<Details>,
}

impl CoefficientPlane {
    /// Transforms a plane.
    pub fn new(plane: &Plane) -> Self {
        let size = layout::coefficient_size(plane.size);
        let coefficients: Vec<Coefficients> = (0..size[0] as usize * size[1] as usize)
            .into_par_iter()
            .map(|i| haar(plane.quad(i as u32 % size[0], i as u32 / size[0])))
            .collect();
        Self {
            low_band: Plane {
                size,
                values: coefficients.iter().map(|c| c.ll / 2.0).collect(),
            },
            details: coefficients.into_iter().map(|c| c.details).collect(),
        }
    }

    /// The details at a position. Outside of the plane they are those of the nearest position
    /// inside.
    pub fn details(&self, x: u32, y: u32) -> Details {
        let [width, height] = self.low_band.size;
        self.details[(y.min(height - 1) * width + x.min(width - 1)) as usize]
    }

    /// The residual of the details after the prediction from the low band `low_band`.
    #[cfg(feature = "encode")]
    fn residual(&self, low_band: &Plane, coding: &PlaneCoding, x: u32, y: u32) -> Details {
        let [width, height] = self.low_band.size;
        let (x, y) = (x.min(width - 1), y.min(height - 1));
        let prediction = predicted(low_band, x, y, coding.predictor);
        let details = self.details(x, y);
        std::array::from_fn(|c| details[c] - prediction[c])
    }
}

/// Reconstructs a plane from its decoded texels: one slice for each texture of the packing, of
/// `texture` texels each.
///
/// # Panics
/// Panics when a slice is shorter than that.
pub fn assemble(
    packing: Packing,
    coding: &PlaneCoding,
    texels: &[Vec<[f32; 4]>],
    texture: [u32; 2],
    plane_size: [u32; 2],
) -> Plane {
    let at = |slice: usize, x: u32, y: u32| texels[slice][(y * texture[0] + x) as usize];
    if !packing.is_wavelet() {
        return Plane::from_fn(plane_size, |x, y| coding.load_low(at(0, x, y)[0]));
    }
    let size = layout::coefficient_size(plane_size);
    let low_band = Plane::from_fn(size, |x, y| {
        coding.load_low(stored_low(packing, at(0, x, y)))
    });
    let mut plane = Plane::from_fn(plane_size, |_, _| 0.0);
    let width = plane_size[0];
    plane
        .values
        .par_chunks_mut(2 * width as usize)
        .enumerate()
        .for_each(|(row, pixels)| {
            let y = row as u32;
            for x in 0..size[0] {
                let stored = match packing {
                    Packing::Split => at(1, x, y),
                    _ => at(0, x, y),
                };
                let left = coding.load_details(stored_details(packing, coding, stored));
                let prediction = predicted(&low_band, x, y, coding.predictor);
                let quad = inverse_haar(Coefficients {
                    ll: 2.0 * low_band.clamped(x, y),
                    details: std::array::from_fn(|c| left[c] + prediction[c]),
                });
                for (i, value) in quad.into_iter().enumerate() {
                    let (px, py) = (2 * x + i as u32 % 2, i as u32 / 2);
                    if let Some(pixel) = pixels.get_mut((py * width + px) as usize)
                        && px < width
                    {
                        *pixel = value;
                    }
                }
            }
        });
    plane
}

/// The channel of a texel that holds the low band.
fn stored_low(packing: Packing, [r, _, b, a]: [f32; 4]) -> f32 {
    match packing {
        Packing::Bc3 => a,
        Packing::Bc7 => b,
        Packing::Split | Packing::Bc4 | Packing::Bc1 => r,
    }
}

/// The channels that hold details. HH, which the BC7 packing drops, is at its zero point.
fn stored_details(packing: Packing, coding: &PlaneCoding, [r, g, b, _]: [f32; 4]) -> Details {
    match packing {
        Packing::Bc7 => [r, g, coding.zero_point[2]],
        _ => [r, g, b],
    }
}

/// Rows of texels that are decoded at a time in packings without a wavelet; a multiple of the block
/// size.
const STRIP: u32 = 256;

/// Decodes a plane from the blocks of each texture of its packing. `decode` converts blocks to
/// texels as [`decode_blocks`] does.
pub fn decode_plane(
    packing: Packing,
    coding: &PlaneCoding,
    blocks: &[&[u8]],
    texture: [u32; 2],
    plane_size: [u32; 2],
    decode: impl Fn(BlockFormat, &[u8], [u32; 2]) -> Vec<[f32; 4]>,
) -> Plane {
    let of = |blocks: &[&[u8]], texture: [u32; 2], plane_size: [u32; 2]| {
        let formats = packing.formats().iter().zip(blocks);
        let texels: Vec<_> = formats.map(|(f, b)| decode(*f, b, texture)).collect();
        assemble(packing, coding, &texels, texture, plane_size)
    };
    if packing.is_wavelet() {
        return of(blocks, texture, plane_size);
    }
    // Decoded texels of 16 bytes take four times the memory of the plane, so they are decoded in
    // strips.
    let mut values = Vec::with_capacity(plane_size[0] as usize * plane_size[1] as usize);
    let strip_bytes = packing.formats()[0].level_bytes([texture[0], STRIP]);
    for (i, strip) in blocks[0].chunks(strip_bytes).enumerate() {
        let first = i as u32 * STRIP;
        if first >= plane_size[1] {
            break;
        }
        let left = |rows: u32| STRIP.min(rows - first);
        let strip = of(
            &[strip],
            [texture[0], left(texture[1])],
            [plane_size[0], left(plane_size[1])],
        );
        values.extend(strip.values);
    }
    Plane {
        size: plane_size,
        values,
    }
}

/// Settings of [`encode_plane`].
#[cfg(feature = "encode")]
#[derive(Clone, Copy, Debug)]
pub struct PackSettings {
    /// The encoding time to spend on quality.
    pub effort: Effort,
    /// Whether to encode as in the thesis, with block encoders that minimise the error of the
    /// stored values instead of the error of the decoded ones.
    pub thesis: bool,
}

/// Encodes a plane at one level and returns the blocks of each texture of the packing. `texture` is
/// the size of the textures in texels.
#[cfg(feature = "encode")]
pub fn encode_plane(
    packing: Packing,
    coding: &PlaneCoding,
    plane: &Plane,
    texture: [u32; 2],
    settings: PackSettings,
) -> Vec<Vec<u8>> {
    let quality = match settings.effort {
        Effort::Fast => BlockQuality::Normal,
        Effort::Default | Effort::Best => BlockQuality::High,
    };
    let singles = |plane: &Plane| {
        let stored = Plane::from_fn(texture, |x, y| coding.store_low(plane.clamped(x, y)));
        encode_bc4(&stored.values, texture, quality)
    };
    match packing {
        Packing::Bc3 if settings.thesis => {
            vec![encode_mixed(
                coding,
                &CoefficientPlane::new(plane),
                texture,
                quality,
            )]
        }
        Packing::Bc3 => {
            let coefficients = CoefficientPlane::new(plane);
            let alpha = singles(&coefficients.low_band);
            let low_band = decoded_low_band(coding, &alpha, texture, coefficients.low_band.size);
            let starts = match settings.effort {
                Effort::Fast => Starts::One,
                Effort::Default => Starts::Two,
                Effort::Best => Starts::Four,
            };
            let encoder = DetailEncoder::new(coding, starts);
            let columns = texture[0].div_ceil(4);
            let color: Vec<[u8; 8]> = (0..columns * texture[1].div_ceil(4))
                .into_par_iter()
                .map(|block| {
                    let details = std::array::from_fn(|i| {
                        let x = block % columns * 4 + i as u32 % 4;
                        let y = block / columns * 4 + i as u32 / 4;
                        coefficients.residual(&low_band, coding, x, y)
                    });
                    encoder.block(&details).0
                })
                .collect();
            vec![with_alpha_blocks(&alpha, &color)]
        }
        Packing::Bc7 => {
            let coefficients = CoefficientPlane::new(plane);
            vec![encode_joint(coding, &coefficients, texture, settings)]
        }
        Packing::Split => {
            let coefficients = CoefficientPlane::new(plane);
            let alpha = singles(&coefficients.low_band);
            let low_band = decoded_low_band(coding, &alpha, texture, coefficients.low_band.size);
            let details = encode_bc7(texture, [1; 3], |x, y| {
                coding.store_details(coefficients.residual(&low_band, coding, x, y))
            });
            vec![alpha, details]
        }
        Packing::Bc4 => vec![singles(plane)],
        Packing::Bc1 => unreachable!("`encoder` packs the two planes of a BC1 texture"),
    }
}

/// The low band as the decoder reconstructs it.
#[cfg(feature = "encode")]
fn decoded_low_band(coding: &PlaneCoding, bc4: &[u8], texture: [u32; 2], size: [u32; 2]) -> Plane {
    let texels = decode_blocks(BlockFormat::Bc4, bc4, texture);
    Plane::from_fn(size, |x, y| {
        coding.load_low(texels[(y * texture[0] + x) as usize][0])
    })
}

/// Encodes BC3 by the library, which treats the stored texels as colours.
#[cfg(feature = "encode")]
fn encode_mixed(
    coding: &PlaneCoding,
    coefficients: &CoefficientPlane,
    texture: [u32; 2],
    quality: BlockQuality,
) -> Vec<u8> {
    let texel = |x: u32, y: u32| -> Texel {
        let [r, g, b] = coding.store_details(coefficients.details(x, y));
        let low = coding.store_low(coefficients.low_band.clamped(x, y));
        [r, g, b, low].map(|v| (v * 255.0).round() as u8)
    };
    let positions = (0..texture[1]).flat_map(|y| (0..texture[0]).map(move |x| (x, y)));
    let texels: Vec<Texel> = positions.map(|(x, y)| texel(x, y)).collect();
    encode_bc3(&texels, texture, quality)
}

/// Encodes the low band and the details together in BC7. The prediction depends on the decoded low
/// band, so the blocks are encoded several times, each time with the low band of the round before,
/// and the best are kept.
#[cfg(feature = "encode")]
fn encode_joint(
    coding: &PlaneCoding,
    coefficients: &CoefficientPlane,
    texture: [u32; 2],
    settings: PackSettings,
) -> Vec<u8> {
    let size = coefficients.low_band.size;
    let rounds = match settings.effort {
        _ if coding.predictor == 0.0 => 1,
        Effort::Fast => 2,
        Effort::Default => 2,
        Effort::Best => 8,
    };
    // An error of the low band changes all four pixels, and the predictions made from it. The
    // thesis weights it 0.6 to 0.2.
    let low_weight = if settings.thesis {
        3
    } else {
        let extent = (coding.low_max - coding.low_min) / coding.range;
        (2.0 * extent * extent).clamp(1.0, 256.0) as u32
    };
    let mut low_band = coefficients.low_band.clone();
    let mut best: Option<(f64, Vec<u8>)> = None;
    for _ in 0..rounds {
        let blocks = encode_bc7(texture, [1, 1, low_weight], |x, y| {
            let residual = coefficients.residual(&low_band, coding, x, y);
            let [r, g, _] = coding.store_details(residual);
            let low = coding.store_low(coefficients.low_band.clamped(x, y));
            [r, g, low]
        });
        let texels = decode_blocks(BlockFormat::Bc7, &blocks, texture);
        let texel = |x: u32, y: u32| texels[(y * texture[0] + x) as usize];
        low_band = Plane::from_fn(size, |x, y| {
            coding.load_low(stored_low(Packing::Bc7, texel(x, y)))
        });
        let error: f64 = (0..size[1])
            .into_par_iter()
            .map(|y| {
                let row = (0..size[0]).map(|x| {
                    let stored = stored_details(Packing::Bc7, coding, texel(x, y));
                    let got = coding.load_details(stored);
                    let wanted = coefficients.residual(&low_band, coding, x, y);
                    let low = low_band.clamped(x, y) - coefficients.low_band.clamped(x, y);
                    let details: f32 = (0..3).map(|c| (got[c] - wanted[c]).powi(2)).sum();
                    f64::from(details + 4.0 * low * low)
                });
                row.sum::<f64>()
            })
            .collect::<Vec<_>>()
            .into_iter()
            .sum();
        if best.as_ref().is_none_or(|(least, _)| error < *least) {
            best = Some((error, blocks));
        }
    }
    best.expect("encoded at least once").1
}

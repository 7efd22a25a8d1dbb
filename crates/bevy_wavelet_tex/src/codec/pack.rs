//! Conversion of one plane at one mip level to blocks.

use rayon::prelude::*;

use super::{
    blocks::{
        BlockFormat, BlockQuality, DetailEncoder, Texel, decode_blocks, encode_bc3, encode_bc4,
        encode_bc7, map_blocks, with_alpha_blocks,
    },
    haar::Details,
    packing::Packing,
    plane::Plane,
    quantizer::PlaneCoding,
    settings::{Effort, EncodeSettings, Method},
    wavelet::{CoefficientPlane, stored_details, stored_low},
};

/// The values of a plane at one level, as a packing stores them.
pub enum PlaneValues {
    /// The pixels.
    Pixels(Plane),
    /// The coefficients of a wavelet.
    Coefficients(CoefficientPlane),
}

impl PlaneValues {
    /// Returns the values that a packing stores of a plane.
    pub fn new(packing: Packing, plane: Plane) -> Self {
        if packing.is_wavelet() {
            Self::Coefficients(CoefficientPlane::new(&plane))
        } else {
            Self::Pixels(plane)
        }
    }

    /// The coefficients, where there are any.
    pub fn coefficients(&self) -> Option<&CoefficientPlane> {
        match self {
            Self::Pixels(_) => None,
            Self::Coefficients(coefficients) => Some(coefficients),
        }
    }
}

/// Encodes a plane at one level and returns the blocks of each texture of the packing. `texture` is
/// the size of the textures in texels. Block encoders as those of the thesis minimise the error of the stored values
/// instead of the error of the decoded ones.
pub fn encode_plane(
    packing: Packing,
    coding: &PlaneCoding,
    values: &PlaneValues,
    texture: [u32; 2],
    settings: &EncodeSettings,
) -> Vec<Vec<u8>> {
    let quality = settings.effort.block_quality();
    let is_thesis = settings.method == Method::Thesis;
    let singles = |plane: &Plane| {
        let stored = Plane::from_fn(texture, |x, y| coding.store_low(plane.clamped(x, y)));
        encode_bc4(&stored.values, texture, quality)
    };
    let coefficients = match values {
        PlaneValues::Pixels(plane) => return vec![singles(plane)],
        PlaneValues::Coefficients(coefficients) => coefficients,
    };
    match packing {
        Packing::Bc3 if is_thesis => {
            vec![encode_mixed(coding, coefficients, texture, quality)]
        }
        Packing::Bc3 => {
            let encoder = DetailEncoder::new(coding, settings.effort.starts());
            let encoded = |target: &Plane| {
                let alpha = singles(target);
                let low_band = decoded_low_band(coding, &alpha, texture, target.size);
                encode_details(&encoder, coding, coefficients, alpha, &low_band, texture)
            };
            let mut best = encoded(&coefficients.low_band);
            let rounds = match settings.effort {
                _ if coding.predictor == 0.0 => 0,
                Effort::Fast => 0,
                Effort::Default => 1,
                Effort::Best => 3,
            };
            for _ in 0..rounds {
                let target = predicting_low_band(coding, coefficients, &best.color, texture);
                let next = encoded(&target);
                if next.error >= best.error {
                    break;
                }
                best = next;
            }
            vec![with_alpha_blocks(&best.alpha, &best.color)]
        }
        Packing::Bc7 => {
            let rounds = match settings.effort {
                _ if coding.predictor == 0.0 => 1,
                Effort::Fast | Effort::Default => 2,
                Effort::Best => 8,
            };
            let low_weight = match is_thesis {
                true => 3,
                false => low_weight(coding),
            };
            let blocks = encode_joint(coding, coefficients, texture, rounds, low_weight);
            vec![blocks]
        }
        Packing::Split => {
            let alpha = singles(&coefficients.low_band);
            let low_band = decoded_low_band(coding, &alpha, texture, coefficients.low_band.size);
            let details = encode_bc7(texture, [1; 3], |x, y| {
                coding.store_details(coefficients.residual(&low_band, coding, x, y))
            });
            vec![alpha, details]
        }
        Packing::Bc4 | Packing::Bc1 => unreachable!("these packings store pixels"),
    }
}

/// Both halves of the blocks of BC3, and the squared error of their coefficients.
struct Halves {
    alpha: Vec<u8>,
    color: Vec<[u8; 8]>,
    error: f64,
}

/// Encodes what the prediction from a decoded low band leaves of the details.
fn encode_details(
    encoder: &DetailEncoder<'_>,
    coding: &PlaneCoding,
    coefficients: &CoefficientPlane,
    alpha: Vec<u8>,
    low_band: &Plane,
    texture: [u32; 2],
) -> Halves {
    let blocks = map_blocks(texture, |at| {
        let details = at.map(|(x, y)| coefficients.residual(low_band, coding, x, y));
        let (block, error) = encoder.block(&details);
        let of_low = at.iter().map(|&(x, y)| {
            let error = low_band.clamped(x, y) - coefficients.low_band.clamped(x, y);
            4.0 * error * error
        });
        (block, error + of_low.sum::<f32>())
    });
    Halves {
        alpha,
        error: blocks.iter().map(|(_, error)| f64::from(*error)).sum(),
        color: blocks.into_iter().map(|(block, _)| block).collect(),
    }
}

/// The low band that has the least error together with what is predicted from it, where details are stored already: a step
/// of the Jacobi method from the true one.
fn predicting_low_band(
    coding: &PlaneCoding,
    coefficients: &CoefficientPlane,
    color: &[[u8; 8]],
    texture: [u32; 2],
) -> Plane {
    let truth = &coefficients.low_band;
    let [width, height] = truth.size;
    let stored = decode_blocks(BlockFormat::Bc1, color.as_flattened(), texture);
    let row = |y: u32| -> Vec<Details> {
        let missing = |x: u32| {
            let stored = stored[(y * texture[0] + x) as usize];
            let got = coding.load_details(stored_details(Packing::Bc3, coding, stored));
            let expected = coefficients.residual(truth, coding, x, y);
            std::array::from_fn(|c| expected[c] - got[c])
        };
        (0..width).map(missing).collect()
    };
    let missing: Vec<Vec<Details>> = (0..height).into_par_iter().map(row).collect();
    let at = |x: i64, y: i64| -> Details {
        let inside = (0..i64::from(width)).contains(&x) && (0..i64::from(height)).contains(&y);
        if inside {
            missing[y as usize][x as usize]
        } else {
            [0.0; 3]
        }
    };
    // What a value of the low band adds to the predictions around it.
    let side = 2.0 * coding.predictor;
    let corner = 2.0 * coding.predictor * coding.predictor;
    let weight = 4.0 + 4.0 * side * side + 4.0 * corner * corner;
    Plane::from_fn(truth.size, |px, py| {
        let (x, y) = (i64::from(px), i64::from(py));
        let across = at(x + 1, y)[0] - at(x - 1, y)[0];
        let down = at(x, y + 1)[1] - at(x, y - 1)[1];
        let diagonal =
            at(x + 1, y + 1)[2] - at(x - 1, y + 1)[2] - at(x + 1, y - 1)[2] + at(x - 1, y - 1)[2];
        truth.clamped(px, py) + (side * (across + down) + corner * diagonal) / weight
    })
}

/// The squared error of the coefficients in the blocks of each texture, which is that of the pixels.
pub fn error_of(
    packing: Packing,
    coding: &PlaneCoding,
    coefficients: &CoefficientPlane,
    blocks: &[Vec<u8>],
    texture: [u32; 2],
) -> f64 {
    let formats = packing.formats().iter().zip(blocks);
    let texels: Vec<Vec<[f32; 4]>> = formats
        .map(|(format, blocks)| decode_blocks(*format, blocks, texture))
        .collect();
    let at = |slice: usize, x: u32, y: u32| texels[slice][(y * texture[0] + x) as usize];
    let last = texels.len() - 1;
    let low_band = Plane::from_fn(coefficients.low_band.size, |x, y| {
        coding.load_low(stored_low(packing, at(0, x, y)))
    });
    error_of_texels(packing, coding, coefficients, &low_band, |x, y| {
        at(last, x, y)
    })
}

/// The same, where the low band is decoded already. `texel` returns the decoded texels of the details.
fn error_of_texels(
    packing: Packing,
    coding: &PlaneCoding,
    coefficients: &CoefficientPlane,
    low_band: &Plane,
    texel: impl Fn(u32, u32) -> [f32; 4] + Sync,
) -> f64 {
    let [width, height] = low_band.size;
    let of_row = |y: u32| {
        let row = (0..width).map(|x| {
            let got = coding.load_details(stored_details(packing, coding, texel(x, y)));
            let expected = coefficients.residual(low_band, coding, x, y);
            let low = low_band.clamped(x, y) - coefficients.low_band.clamped(x, y);
            let details: f32 = (0..3).map(|c| (got[c] - expected[c]).powi(2)).sum();
            f64::from(details + 4.0 * low * low)
        });
        row.sum::<f64>()
    };
    let rows: Vec<f64> = (0..height).into_par_iter().map(of_row).collect();
    rows.into_iter().sum()
}

/// The low band as the decoder reconstructs it.
fn decoded_low_band(coding: &PlaneCoding, bc4: &[u8], texture: [u32; 2], size: [u32; 2]) -> Plane {
    let texels = decode_blocks(BlockFormat::Bc4, bc4, texture);
    Plane::from_fn(size, |x, y| {
        coding.load_low(texels[(y * texture[0] + x) as usize][0])
    })
}

/// Encodes BC3 by the library, which treats the stored texels as colours.
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
    let positions = Plane::positions(texture);
    let texels: Vec<Texel> = positions.map(|(x, y)| texel(x, y)).collect();
    encode_bc3(&texels, texture, quality)
}

/// Encodes the low band and the details together in BC7. The prediction depends on the decoded low
/// band, so the blocks are encoded several times, each time with the low band of the round before,
/// and the best are kept.
fn encode_joint(
    coding: &PlaneCoding,
    coefficients: &CoefficientPlane,
    texture: [u32; 2],
    rounds: u32,
    low_weight: u32,
) -> Vec<u8> {
    let size = coefficients.low_band.size;
    let mut low_band = coefficients.low_band.clone();
    let mut best: Option<(f64, Vec<u8>)> = None;
    for _ in 0..rounds {
        let blocks = encode_bc7(texture, [1, 1, low_weight], |x, y| {
            let residual = coefficients.residual(&low_band, coding, x, y);
            let [r, g, _] = coding.store_details(residual);
            let low = coding.store_low(coefficients.low_band.clamped(x, y));
            [r, g, low]
        });
        if rounds == 1 {
            return blocks;
        }
        let texels = decode_blocks(BlockFormat::Bc7, &blocks, texture);
        let texel = |x: u32, y: u32| texels[(y * texture[0] + x) as usize];
        low_band = Plane::from_fn(size, |x, y| {
            coding.load_low(stored_low(Packing::Bc7, texel(x, y)))
        });
        let error = error_of_texels(Packing::Bc7, coding, coefficients, &low_band, texel);
        if best.as_ref().is_none_or(|(least, _)| error < *least) {
            best = Some((error, blocks));
        }
    }
    best.expect("encoded at least once").1
}

/// The weight of the squared error of the low band in BC7 blocks that hold it with details. An error of it changes all
/// four pixels, and the predictions made from it. The thesis weights it 0.6 to 0.2.
pub fn low_weight(coding: &PlaneCoding) -> u32 {
    let extent = (coding.low_max - coding.low_min) / coding.range;
    (2.0 * extent * extent).clamp(1.0, 256.0) as u32
}

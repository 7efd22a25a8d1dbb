//! Conversion of one plane at one mip level to coefficients, and from blocks back.

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
        let mut low_band = Plane::from_fn(size, |_, _| 0.0);
        let mut details = vec![[0.0; 3]; low_band.values.len()];
        let width = size[0] as usize;
        let rows = low_band.values.par_chunks_mut(width);
        let rows = rows.zip(details.par_chunks_mut(width)).enumerate();
        rows.for_each(|(y, (low_band, details))| {
            for (x, (low, of)) in low_band.iter_mut().zip(details).enumerate() {
                let coefficients = haar(plane.quad(x as u32, y as u32));
                (*low, *of) = (coefficients.ll / 2.0, coefficients.details);
            }
        });
        Self { low_band, details }
    }

    /// The details at a position. Outside of the plane they are those of the nearest position
    /// inside.
    pub fn details(&self, x: u32, y: u32) -> Details {
        let [width, height] = self.low_band.size;
        self.details[(y.min(height - 1) * width + x.min(width - 1)) as usize]
    }

    /// The residual of the details after the prediction from the low band `low_band`.
    #[cfg(feature = "encode")]
    pub(super) fn residual(
        &self,
        low_band: &Plane,
        coding: &PlaneCoding,
        x: u32,
        y: u32,
    ) -> Details {
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
pub(super) fn stored_low(packing: Packing, [r, _, b, a]: [f32; 4]) -> f32 {
    match packing {
        Packing::Bc3 => a,
        Packing::Bc7 => b,
        Packing::Split | Packing::Bc4 | Packing::Bc1 => r,
    }
}

/// The channels that hold details. HH, which the BC7 packing drops, is at its zero point.
pub(super) fn stored_details(
    packing: Packing,
    coding: &PlaneCoding,
    [r, g, b, _]: [f32; 4],
) -> Details {
    match packing {
        Packing::Bc7 => [r, g, coding.zero_point[2]],
        _ => [r, g, b],
    }
}

/// Rows of texels that are decoded at a time in packings without a wavelet; a multiple of the block
/// size.
const STRIP: u32 = 256;

/// Decodes a plane from the blocks of each texture of its packing. `decode` converts blocks to
/// texels as [`decode_blocks`](super::blocks::decode_blocks) does.
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

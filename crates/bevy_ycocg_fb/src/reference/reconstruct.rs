//! Reconstruction of a colour from a packed pixel and its neighbours (thesis 4.5).
//!
//! # Guided filters
//! [`guided`], [`wide`] and [`in_quad`] estimate the missing chrominance relative to luminance. This
//! ratio hardly changes from light to shadow, while chrominance itself is proportional to the light.
//! All terms of the filters are ratios, so that exposure cancels out; the thesis's threshold of 30/255
//! detects no edge in a dark picture and nothing but edges in a bright one. For the neighbours `i` of a
//! pixel `0`, of luminance `Y` and chrominance `C`:
//!
//! ```text
//! k_i = clamp(C_i / max(Y_i, FLOOR), -2, 2)                        chrominance ratio
//! d_i = |Y_i - Y_0| / max(min(Y_i, Y_0), FLOOR)                    luminance difference
//! t   = 0.02 + 4 min(d_i)                                          difference that is tolerated
//! g_i = |k_right - k_left| or |k_below - k_above|, i's axis        chrominance change
//! h_i = |(k_p + k_q) / 2 - k_0|, p and q the diagonals beside i    change of the other chrominance
//!
//! w_i = 1 / ((t + d_i) (0.2 + g_i))^2                              guided
//! w_i = 1 / ((t + d_i) (0.2 + g_i) (0.2 + h_i))^2                  wide
//! w_i = 1 / (t + d_i)^2                                            in_quad
//!
//! C_0 = Y_0 sum(w_i k_i) / sum(w_i)
//! ```
//!
//! `t` depends on the most similar neighbour: in flat areas the filter is strict, in noise it averages,
//! and if all neighbours differ much, the most similar one in luminance dominates, which the thesis
//! handles as a special case. All weights are positive, and so is their sum.
//!
//! The result is clamped to the range in which no channel of the colour is negative ([`decode`]);
//! the stored chrominance is not changed.
//!
//! # Samples
//! All samples of a pixel store the same kind of chrominance (thesis 4.7.1), so they can be averaged
//! before the reconstruction ([`resolved`]). Those of the 8-bit format are gamma-encoded: their mean is that of an edge
//! that is too dark, so it serves the reconstruction only, and the colours of the samples are averaged in linear light
//! ([`mean_in_linear_light`]).

use super::pack::{F16_MAX, PackedImage, PackedPixel, YCoCg, linear_from_srgb, rgb_from_ycocg};
use crate::settings::{MsaaResolve, PackedFormat, Reconstruction};

/// Luminance difference from which the thesis's filter detects an edge (thesis 4.5).
pub const EDGE_THRESHOLD: f32 = 30.0 / 255.0;

/// Lower limit of the luminance in ratios: 16-bit floats have only 4 bits left there.
pub const FLOOR: f32 = 1.0 / (1 << 20) as f32;

/// Relative difference of luminance that is always tolerated.
pub const TOLERANCE: f32 = 0.02;

/// Factor of the most similar neighbour's difference, which is tolerated in addition to [`TOLERANCE`].
pub const TOLERANCE_GROWTH: f32 = 4.0;

/// Change of the chrominance ratio at which a weight has fallen to a quarter.
pub const CHROMINANCE_SCALE: f32 = 0.2;

/// The four neighbours with the missing chrominance.
///
/// An axis along which the image has a single pixel has no neighbours.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cross {
    /// Neighbours to the right and to the left.
    pub horizontal: Option<[PackedPixel; 2]>,
    /// Neighbours below and above.
    pub vertical: Option<[PackedPixel; 2]>,
}

impl PackedImage {
    /// Reconstructs the colours of all pixels, in the units of the input of [`pack`](Self::pack).
    pub fn unpack(&self, filter: Reconstruction) -> Vec<[f32; 3]> {
        let positions = (0..self.size[1]).flat_map(|y| (0..self.size[0]).map(move |x| (x, y)));
        let colors = positions.map(|(x, y)| reconstruct(self, x, y, filter));
        match self.format {
            PackedFormat::Float16 | PackedFormat::Float32 => colors.collect(),
            PackedFormat::Unorm8 => colors
                .map(|color| color.map(|c| linear_from_srgb(c.clamp(0.0, 1.0))))
                .collect(),
        }
    }
}

/// Reconstructs the colour of a pixel of an image.
pub fn reconstruct(image: &PackedImage, x: u32, y: u32, filter: Reconstruction) -> [f32; 3] {
    let (column, row) = (i64::from(x), i64::from(y));
    let center = image.read(column, row);
    let cross = || Cross::read(image, column, row);
    let missing = match filter {
        Reconstruction::Nearest => nearest(&cross()),
        Reconstruction::Bilinear => bilinear(&cross()),
        Reconstruction::EdgeDirected => edge_directed(center, &cross()),
        Reconstruction::Guided => guided(center, &cross()),
        Reconstruction::Wide => {
            let at = |dx, dy| image.read(column + dx, row + dy);
            wide(
                center,
                &cross(),
                [at(1, 1), at(1, -1), at(-1, 1), at(-1, -1)],
            )
        }
        Reconstruction::Quad => {
            // The quads are those of the target, not of the viewport.
            let partner = |c: u32, offset: u32| i64::from((c + offset) ^ 1) - i64::from(offset);
            let [width, height] = image.size;
            in_quad(
                center,
                (width > 1).then(|| image.read(partner(x, image.offset[0]), row)),
                (height > 1).then(|| image.read(column, partner(y, image.offset[1]))),
            )
        }
    };
    decode(center, missing, image.stores_co(x, y))
}

/// Decodes the colour of a packed pixel and its missing chrominance, with all channels from 0 to the
/// largest 16-bit float.
pub fn decode(pixel: PackedPixel, missing: f32, stores_co: bool) -> [f32; 3] {
    let y = pixel.luminance;
    let (co, cg) = if stores_co {
        let co = pixel.chrominance;
        (co, missing.min(y - co.abs()).max(-y))
    } else {
        let cg = pixel.chrominance;
        (missing.min(y - cg).max(cg - y), cg)
    };
    // After blending and rounding, the stored chrominance itself can still be out of range.
    rgb_from_ycocg(YCoCg { y, co, cg }).map(|channel| channel.clamp(0.0, F16_MAX))
}

/// Returns the chrominance of the neighbour to the right; without one, of that below; else 0.
pub fn nearest(cross: &Cross) -> f32 {
    cross.pixels().next().map_or(0.0, |pixel| pixel.chrominance)
}

/// Returns the mean chrominance of the neighbours.
pub fn bilinear(cross: &Cross) -> f32 {
    weighted_mean(cross.pixels().map(|pixel| (1.0, pixel.chrominance)))
}

/// Returns the mean chrominance of those neighbours whose luminance differs by less than
/// [`EDGE_THRESHOLD`], or of the first neighbour if there are none (thesis, listing 4.2).
pub fn edge_directed(center: PackedPixel, cross: &Cross) -> f32 {
    let is_similar = |pixel: &PackedPixel| {
        let difference = (pixel.luminance - center.luminance).abs();
        difference < EDGE_THRESHOLD
    };
    if cross.pixels().any(|pixel| is_similar(&pixel)) {
        let similar = cross.pixels().filter(is_similar);
        weighted_mean(similar.map(|pixel| (1.0, pixel.chrominance)))
    } else {
        nearest(cross)
    }
}

/// Applies the guided filter to the four neighbours; the formula is in the documentation of the [module](self).
pub fn guided(center: PackedPixel, cross: &Cross) -> f32 {
    filtered(center, cross, [[0.0; 2]; 2])
}

/// Applies the guided filter to the eight neighbours; the formula is in the documentation of the [module](self).
///
/// `diagonals` are the neighbours to the lower right, upper right, lower left and upper left. An image
/// with one row or column has none, and the filter is [`guided`].
pub fn wide(center: PackedPixel, cross: &Cross, diagonals: [PackedPixel; 4]) -> f32 {
    if cross.horizontal.is_none() || cross.vertical.is_none() {
        return guided(center, cross);
    }
    let own = ratio(center);
    let [lower_right, upper_right, lower_left, upper_left] = diagonals.map(ratio);
    let change = |p: f32, q: f32| (0.5 * (p + q) - own).abs();
    let changes = [
        [
            change(lower_right, upper_right),
            change(lower_left, upper_left),
        ],
        [
            change(lower_right, lower_left),
            change(upper_right, upper_left),
        ],
    ];
    filtered(center, cross, changes)
}

/// Applies the guided filter with the two neighbours in the same quad; the formula is in the
/// documentation of the [module](self).
pub fn in_quad(
    center: PackedPixel,
    horizontal: Option<PackedPixel>,
    vertical: Option<PackedPixel>,
) -> f32 {
    let pixels = || [horizontal, vertical].into_iter().flatten();
    let tolerance = tolerance(center, pixels());
    let weighted = pixels().map(|pixel| {
        let root = 1.0 / (tolerance + difference(center, pixel));
        (root * root, ratio(pixel))
    });
    center.luminance * weighted_mean(weighted)
}

/// The common part of [`guided`] and [`wide`]; `changes` are the changes of the other chrominance to the
/// right and left, below and above.
fn filtered(center: PackedPixel, cross: &Cross, changes: [[f32; 2]; 2]) -> f32 {
    let tolerance = tolerance(center, cross.pixels());
    let axes = [cross.horizontal, cross.vertical].into_iter().zip(changes);
    let weighted = axes.filter_map(|(pixels, changes)| {
        let pixels = pixels?;
        let ratios = pixels.map(ratio);
        let axis = CHROMINANCE_SCALE + (ratios[0] - ratios[1]).abs();
        Some([0, 1].map(|i| {
            let luminance = tolerance + difference(center, pixels[i]);
            let root = 1.0 / (luminance * axis * (CHROMINANCE_SCALE + changes[i]));
            (root * root, ratios[i])
        }))
    });
    center.luminance * weighted_mean(weighted.flatten())
}

/// The ratio of chrominance to luminance: Co from -2 to 2, Cg from -1 to 1.
fn ratio(pixel: PackedPixel) -> f32 {
    (pixel.chrominance / pixel.luminance.max(FLOOR)).clamp(-2.0, 2.0)
}

/// The relative difference of luminance, at least 0.
fn difference(a: PackedPixel, b: PackedPixel) -> f32 {
    (a.luminance - b.luminance).abs() / a.luminance.min(b.luminance).max(FLOOR)
}

fn tolerance(center: PackedPixel, pixels: impl Iterator<Item = PackedPixel>) -> f32 {
    let smallest = pixels
        .map(|pixel| difference(center, pixel))
        .fold(f32::INFINITY, f32::min);
    TOLERANCE + TOLERANCE_GROWTH * smallest
}

/// The mean of pairs of weight and value, or 0 without pairs.
fn weighted_mean(weighted: impl Iterator<Item = (f32, f32)>) -> f32 {
    let (mut weights, mut sum) = (0.0, 0.0);
    for (weight, value) in weighted {
        weights += weight;
        sum += weight * value;
    }
    if weights > 0.0 { sum / weights } else { 0.0 }
}

impl Cross {
    /// Reads the neighbours of a pixel.
    pub fn read(image: &PackedImage, x: i64, y: i64) -> Self {
        Self {
            horizontal: (image.size[0] > 1).then(|| [image.read(x + 1, y), image.read(x - 1, y)]),
            vertical: (image.size[1] > 1).then(|| [image.read(x, y + 1), image.read(x, y - 1)]),
        }
    }

    /// Returns the neighbours that exist, in the order right, left, below, above.
    pub fn pixels(&self) -> impl Iterator<Item = PackedPixel> {
        [self.horizontal, self.vertical]
            .into_iter()
            .flatten()
            .flatten()
    }
}

/// Resolves the samples of a pixel; without samples, the result is black.
pub fn resolved(samples: &[PackedPixel], resolve: MsaaResolve) -> PackedPixel {
    let mut sum = PackedPixel::default();
    let mut weights = 0.0;
    for sample in samples {
        let weight = match resolve {
            MsaaResolve::Box => 1.0,
            MsaaResolve::ToneMapWeighted => 1.0 / (1.0 + sample.luminance.max(0.0)),
        };
        sum.luminance += weight * sample.luminance;
        sum.chrominance += weight * sample.chrominance;
        weights += weight;
    }
    if weights == 0.0 {
        return PackedPixel::default();
    }
    PackedPixel {
        luminance: sum.luminance / weights,
        chrominance: sum.chrominance / weights,
    }
}

/// Returns the display-linear mean of the samples of a pixel in the 8-bit format. `missing_ratio` is the missing
/// chrominance of the pixel, relative to its luminance; `is_co` tells whether the pixel stores Co.
pub fn mean_in_linear_light(samples: &[PackedPixel], missing_ratio: f32, is_co: bool) -> [f32; 3] {
    let mut sum = [0.0; 3];
    for sample in samples {
        let encoded = decode(*sample, missing_ratio * sample.luminance, is_co);
        for (sum, channel) in sum.iter_mut().zip(encoded) {
            *sum += linear_from_srgb(channel.clamp(0.0, 1.0)) / samples.len() as f32;
        }
    }
    sum
}

//! From the thesis's filter to the plugin's, one idea at a time, each with the same neighbours.
//!
//! | setting | what is new |
//! | --- | --- |
//! | `edge_directed` | the thesis: a threshold of 30/255 |
//! | `relative_threshold` | a threshold of 12 percent; where none passes, the most similar neighbour |
//! | `ratio_threshold` | chrominance as a ratio to luminance |
//! | `ratio_power` | smooth weights: the eighth power of the ratio of luminances |
//! | `ratio_smooth` | smooth weights that tolerate 2 percent |
//! | `ratio_adaptive` | what is tolerated grows with the most similar neighbour's difference |
//! | `guided` | and the axis along which chrominance changes less counts more |

use bevy_ycocg_fb::reference::{
    PackedImage, PackedPixel, decode,
    reconstruct::{Cross, FLOOR, TOLERANCE, TOLERANCE_GROWTH},
};

/// A step: its name, and the missing chrominance of a pixel.
pub type Step = (&'static str, fn(PackedPixel, &Cross) -> f32);

/// The steps between the thesis's filter and the plugin's.
pub const STEPS: [Step; 5] = [
    ("relative_threshold", relative_threshold),
    ("ratio_threshold", ratio_threshold),
    ("ratio_power", ratio_power),
    ("ratio_smooth", ratio_smooth),
    ("ratio_adaptive", ratio_adaptive),
];

/// Relative difference of luminance at which a threshold sees an edge.
const THRESHOLD: f32 = 0.12;

/// Reconstructs every pixel with a step.
pub fn unpack(image: &PackedImage, missing: fn(PackedPixel, &Cross) -> f32) -> Vec<[f32; 3]> {
    let positions = (0..image.size[1]).flat_map(|y| (0..image.size[0]).map(move |x| (x, y)));
    let color = |(x, y): (u32, u32)| {
        let center = image.read(x.into(), y.into());
        let cross = Cross::read(image, x.into(), y.into());
        decode(center, missing(center, &cross), image.stores_co(x, y))
    };
    positions.map(color).collect()
}

fn relative_threshold(center: PackedPixel, cross: &Cross) -> f32 {
    thresholded(center, cross, |pixel| pixel.chrominance)
}

fn ratio_threshold(center: PackedPixel, cross: &Cross) -> f32 {
    center.luminance * thresholded(center, cross, ratio)
}

fn ratio_power(center: PackedPixel, cross: &Cross) -> f32 {
    let most = similarity(center, cross);
    // Relative to the most similar one, so that not all weights can be 0.
    let weight = |pixel| ((1.0 + most) / (1.0 + difference(center, pixel))).powi(8);
    center.luminance * mean(cross.pixels().map(|pixel| (weight(pixel), ratio(pixel))))
}

fn ratio_smooth(center: PackedPixel, cross: &Cross) -> f32 {
    tolerant(center, cross, TOLERANCE)
}

fn ratio_adaptive(center: PackedPixel, cross: &Cross) -> f32 {
    let tolerance = TOLERANCE + TOLERANCE_GROWTH * similarity(center, cross);
    tolerant(center, cross, tolerance)
}

fn tolerant(center: PackedPixel, cross: &Cross, tolerance: f32) -> f32 {
    let weight = |pixel| (tolerance + difference(center, pixel)).powi(-2);
    center.luminance * mean(cross.pixels().map(|pixel| (weight(pixel), ratio(pixel))))
}

fn thresholded(center: PackedPixel, cross: &Cross, value: fn(PackedPixel) -> f32) -> f32 {
    let limit = THRESHOLD.max(similarity(center, cross));
    let similar = cross
        .pixels()
        .filter(|pixel| difference(center, *pixel) <= limit);
    mean(similar.map(|pixel| (1.0, value(pixel))))
}

/// Smallest relative difference of luminance of the neighbours.
fn similarity(center: PackedPixel, cross: &Cross) -> f32 {
    let differences = cross.pixels().map(|pixel| difference(center, pixel));
    differences.fold(f32::INFINITY, f32::min)
}

pub(super) fn difference(a: PackedPixel, b: PackedPixel) -> f32 {
    (a.luminance - b.luminance).abs() / a.luminance.min(b.luminance).max(FLOOR)
}

pub(super) fn ratio(pixel: PackedPixel) -> f32 {
    (pixel.chrominance / pixel.luminance.max(FLOOR)).clamp(-2.0, 2.0)
}

pub(super) fn mean(weighted: impl Iterator<Item = (f32, f32)>) -> f32 {
    let (weights, sum) = weighted.fold((0.0, 0.0), |(weights, sum), (weight, value)| {
        (weights + weight, sum + weight * value)
    });
    if weights > 0.0 { sum / weights } else { 0.0 }
}

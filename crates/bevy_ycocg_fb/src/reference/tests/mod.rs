//! Properties that hold for every colour, position and filter.

mod extremes;
mod filters;
mod pixels;

use super::*;
use crate::settings::{PackedFormat, Reconstruction};

pub(super) const FILTERS: [Reconstruction; 6] = [
    Reconstruction::Nearest,
    Reconstruction::Bilinear,
    Reconstruction::EdgeDirected,
    Reconstruction::Guided,
    Reconstruction::Wide,
    Reconstruction::Quad,
];

/// The guided filters, which guarantee more than those of the thesis.
pub(super) const GUIDED_FILTERS: [Reconstruction; 3] = [
    Reconstruction::Guided,
    Reconstruction::Wide,
    Reconstruction::Quad,
];

/// Packs and unpacks an image whose colours are a function of the pixel position.
pub(super) fn round_trip(
    size: [u32; 2],
    offset: [u32; 2],
    format: PackedFormat,
    filter: Reconstruction,
    color: impl Fn(u32, u32) -> [f32; 3],
) -> Vec<[f32; 3]> {
    let positions = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y)));
    let colors: Vec<_> = positions.map(|(x, y)| color(x, y)).collect();
    PackedImage::pack(&colors, size, offset, format).unpack(filter)
}

/// Returns the largest difference of a channel, relative to the largest channel of the expected colour.
pub(super) fn relative_error(actual: [f32; 3], expected: [f32; 3]) -> f32 {
    let scale = expected.iter().fold(1e-30f32, |a, b| a.max(b.abs()));
    let differences = actual.iter().zip(expected).map(|(a, e)| (a - e).abs());
    differences.fold(0.0, f32::max) / scale
}

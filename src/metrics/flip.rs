//! FLIP: the difference a viewer notices when flipping between two images.
//!
//! After P. Andersson, J. Nilsson, T. Akenine-Möller, M. Oskarsson, K. Åström, M. D. Fairchild:
//! "FLIP: A Difference Evaluator for Alternating Images", Proc. ACM Comput. Graph. Interact.
//! Tech. 3(2), article 15, HPG 2020. Two pipelines, as the paper calls them, meet in one number per
//! pixel:
//!
//! ```text
//! sRGB -> YCxCz -> contrast sensitivity filter -> Lab, Hunt -> HyAB -> remap -> colour
//!         Y -----> edge and point detectors -> larger difference -> root ----> feature
//!         error = colour ^ (1 - feature)
//! ```
//!
//! An implementation of our own, because the only binding needs a C++ compiler and this project
//! builds with a bare Rust toolchain. Every two-dimensional filter of the paper is a sum of
//! separable ones and is applied as such; images continue beyond their borders with their outermost
//! pixels. The tests hold it to the authors' own program.

mod color;
mod kernel;
mod plane;

use image::RgbImage;
use rayon::prelude::*;

use super::error::{SizeMismatch, check_sizes};
use color::{ColorDistance, YCxCz};
use kernel::{FeatureKernel, SpatialKernel};
use plane::Plane;

/// Pixels per degree of visual angle of the paper's default viewer: 0.7 m from a display 0.7 m
/// and 3840 pixels wide.
pub const DEFAULT_PIXELS_PER_DEGREE: f32 = 67.02;

/// Weight of the feature difference as an exponent, q_f in the paper.
const FEATURE_EXPONENT: f32 = 0.5;

/// The FLIP error of every pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct FlipMap {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Errors in raster order, `width * height` values from 0 (equal) to 1.
    pub values: Vec<f32>,
}

impl FlipMap {
    /// Mean error, 0 to 1: the figure the paper reports for a pair of images. 0 without pixels.
    pub fn mean(&self) -> f64 {
        let sum: f64 = self.values.iter().copied().map(f64::from).sum();
        sum / self.values.len().max(1) as f64
    }
}

/// Computes the FLIP error of every pixel of two sRGB images.
///
/// `pixels_per_degree` is the resolution at the viewer's eye, usually
/// [`DEFAULT_PIXELS_PER_DEGREE`]; it is clamped to 1 to 1000, beyond which the filters have no
/// meaning. Runs on the current `rayon` pool; the result does not depend on its size.
pub fn flip_map(
    reference: &RgbImage,
    test: &RgbImage,
    pixels_per_degree: f32,
) -> Result<FlipMap, SizeMismatch> {
    check_sizes(reference, test)?;
    let (width, height) = reference.dimensions();
    let pixels_per_degree = pixels_per_degree.clamp(1.0, 1000.0);
    let spatial = SpatialKernel::new(pixels_per_degree);
    let feature = FeatureKernel::new(pixels_per_degree);
    let (reference, test) = rayon::join(
        || Appearance::new(reference, &spatial, &feature),
        || Appearance::new(test, &spatial, &feature),
    );
    let distance = ColorDistance::new();
    let values = (0..reference.edge.values.len())
        .into_par_iter()
        .map(|i| {
            let color = distance.between(reference.filtered.at(i), test.filtered.at(i));
            let edge = (reference.edge.values[i] - test.edge.values[i]).abs();
            let point = (reference.point.values[i] - test.point.values[i]).abs();
            let feature =
                (edge.max(point) * std::f32::consts::FRAC_1_SQRT_2).powf(FEATURE_EXPONENT);
            color.powf(1.0 - feature)
        })
        .collect();
    Ok(FlipMap {
        width,
        height,
        values,
    })
}

/// What the viewer sees of one image: blurred colours, and the strengths of edges and points.
struct Appearance {
    filtered: YCxCz,
    edge: Plane,
    point: Plane,
}

impl Appearance {
    fn new(image: &RgbImage, spatial: &SpatialKernel, feature: &FeatureKernel) -> Self {
        let opponent = YCxCz::new(image);

        let gray = opponent.y.map(|y| (y + 16.0) / 116.0);
        let gaussian_x = gray.filter_rows(&feature.gaussian);
        let edge = Plane::norm(
            &gray
                .filter_rows(&feature.edge)
                .filter_columns(&feature.gaussian),
            &gaussian_x.filter_columns(&feature.edge),
        );
        let point = Plane::norm(
            &gray
                .filter_rows(&feature.point)
                .filter_columns(&feature.gaussian),
            &gaussian_x.filter_columns(&feature.point),
        );

        Self {
            filtered: spatial.apply(&opponent),
            edge,
            point,
        }
    }
}

#[cfg(test)]
mod tests;

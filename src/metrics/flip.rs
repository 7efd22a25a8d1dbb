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

use std::f32::consts::PI;

use bevy_wavelet_tex::codec::color::linear_from_srgb;
use image::RgbImage;
use rayon::prelude::*;

use crate::metrics::{SizeMismatch, check_sizes};

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

/// Exponent that compresses large colour distances, q_c in the paper.
const DISTANCE_EXPONENT: f32 = 0.7;
/// The distances up to this fraction of the largest, p_c, ...
const KNEE_DISTANCE: f32 = 0.4;
/// ... are mapped to this share of the error range, p_t.
const KNEE_ERROR: f32 = 0.95;

/// Linear sRGB to CIE XYZ under D65, in the rationals of the paper's reference program.
const XYZ_FROM_RGB: [[f32; 3]; 3] = [
    [
        10135552.0 / 24577794.0,
        8788810.0 / 24577794.0,
        4435075.0 / 24577794.0,
    ],
    [
        2613072.0 / 12288897.0,
        8788810.0 / 12288897.0,
        887015.0 / 12288897.0,
    ],
    [
        1425312.0 / 73733382.0,
        8788810.0 / 73733382.0,
        70074185.0 / 73733382.0,
    ],
];
/// Inverse of [`XYZ_FROM_RGB`].
const RGB_FROM_XYZ: [[f32; 3]; 3] = [
    [3.241_003_3, -1.537_398_9, -0.498_615_86],
    [-0.969_224_33, 1.875_930_1, 0.041_554_224],
    [0.055_639_423, -0.204_011_2, 1.057_148_9],
];
/// XYZ of the D65 white: the row sums of [`XYZ_FROM_RGB`].
const WHITE_XYZ: [f32; 3] = [0.950_428_55, 1.0, 1.088_900_4];

/// An image in YCxCz, a linear opponent space: luminance, red-green and blue-yellow. Linear, so
/// that filtering it averages light as the eye does.
struct YCxCz {
    y: Plane,
    cx: Plane,
    cz: Plane,
}

impl YCxCz {
    /// Decodes an sRGB image.
    fn new(image: &RgbImage) -> Self {
        let linear: [f32; 256] = std::array::from_fn(|code| linear_from_srgb(code as f32 / 255.0));
        let channel = |component: fn([f32; 3]) -> f32| Plane {
            width: image.width() as usize,
            height: image.height() as usize,
            values: image
                .as_raw()
                .par_chunks_exact(3)
                .map(|rgb| {
                    let rgb = [0, 1, 2].map(|c| linear[usize::from(rgb[c])]);
                    component(relative_to_white(transform(&XYZ_FROM_RGB, rgb)))
                })
                .collect(),
        };
        Self {
            y: channel(|[_, y, _]| 116.0 * y - 16.0),
            cx: channel(|[x, y, _]| 500.0 * (x - y)),
            cz: channel(|[_, y, z]| 200.0 * (y - z)),
        }
    }

    /// The colour with raster index `i`.
    fn at(&self, i: usize) -> [f32; 3] {
        [self.y.values[i], self.cx.values[i], self.cz.values[i]]
    }
}

/// The remapped colour distance, with its scale.
struct ColorDistance {
    largest: f32,
}

impl ColorDistance {
    /// The scale is set by the two most distant colours of sRGB, green and blue.
    fn new() -> Self {
        let [green, blue] = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(hunt_lab);
        Self {
            largest: hyab(green, blue).powf(DISTANCE_EXPONENT),
        }
    }

    /// Colour error, 0 to 1, of two filtered YCxCz colours.
    fn between(&self, a: [f32; 3], b: [f32; 3]) -> f32 {
        let distance =
            hyab(hunt_lab(clamped_rgb(a)), hunt_lab(clamped_rgb(b))).powf(DISTANCE_EXPONENT);
        let knee = KNEE_DISTANCE * self.largest;
        if distance < knee {
            distance * KNEE_ERROR / knee
        } else {
            KNEE_ERROR + (distance - knee) / (self.largest - knee) * (1.0 - KNEE_ERROR)
        }
    }
}

/// Linear RGB of a YCxCz colour, brought back into the gamut that filtering may leave.
fn clamped_rgb([y, cx, cz]: [f32; 3]) -> [f32; 3] {
    let y = (y + 16.0) / 116.0;
    let [wx, wy, wz] = WHITE_XYZ;
    let xyz = [(y + cx / 500.0) * wx, y * wy, (y - cz / 200.0) * wz];
    transform(&RGB_FROM_XYZ, xyz).map(|channel| channel.clamp(0.0, 1.0))
}

/// CIELAB of a linear RGB colour with its chroma scaled by lightness: the Hunt effect, by which
/// colours look less saturated the darker they are.
fn hunt_lab(rgb: [f32; 3]) -> [f32; 3] {
    const DELTA: f32 = 6.0 / 29.0;
    let [x, y, z] = relative_to_white(transform(&XYZ_FROM_RGB, rgb)).map(|t| {
        if t > DELTA * DELTA * DELTA {
            t.cbrt()
        } else {
            t / (3.0 * DELTA * DELTA) + 4.0 / 29.0
        }
    });
    let lightness = 116.0 * y - 16.0;
    let hunt = 0.01 * lightness;
    [lightness, hunt * 500.0 * (x - y), hunt * 200.0 * (y - z)]
}

/// HyAB distance: city-block in lightness, Euclidean in chroma, which suits large differences.
fn hyab(a: [f32; 3], b: [f32; 3]) -> f32 {
    (a[0] - b[0]).abs() + (a[1] - b[1]).hypot(a[2] - b[2])
}

fn relative_to_white(xyz: [f32; 3]) -> [f32; 3] {
    std::array::from_fn(|c| xyz[c] / WHITE_XYZ[c])
}

fn transform(matrix: &[[f32; 3]; 3], v: [f32; 3]) -> [f32; 3] {
    matrix.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// Gaussians of the contrast sensitivity functions as (a, b) of `a sqrt(π/b) exp(-π² x² / b)`,
/// x in degrees, with the paper's values. The blue-yellow one is a sum of two.
const ACHROMATIC: (f32, f32) = (1.0, 0.0047);
const RED_GREEN: (f32, f32) = (1.0, 0.0053);
const BLUE_YELLOW: [(f32, f32); 2] = [(34.1, 0.04), (13.5, 0.025)];

/// Width of the feature detectors in degrees, w in the paper.
const FEATURE_WIDTH_DEGREES: f32 = 0.082;

/// The contrast sensitivity filter: what is left of a pattern at the eye's resolution.
struct SpatialKernel {
    achromatic: Vec<f32>,
    red_green: Vec<f32>,
    blue_yellow: [Vec<f32>; 2],
}

impl SpatialKernel {
    /// Kernels of three standard deviations of the widest Gaussian.
    fn new(pixels_per_degree: f32) -> Self {
        let sigma_degrees = (BLUE_YELLOW[0].1 / (2.0 * PI * PI)).sqrt();
        let radius = (3.0 * sigma_degrees * pixels_per_degree).ceil() as i32;
        let gaussian = |(a, b): (f32, f32)| -> Vec<f32> {
            // The square root of the amplitude: a kernel is applied once along each axis.
            let amplitude = (a * (PI / b).sqrt()).sqrt();
            taps(radius, |x| {
                let degrees = x / pixels_per_degree;
                amplitude * (-PI * PI * degrees * degrees / b).exp()
            })
        };
        let normalized = |mut kernel: Vec<f32>, integral: f32| {
            kernel
                .iter_mut()
                .for_each(|weight| *weight /= integral.sqrt());
            kernel
        };
        // Integral over the plane of a kernel applied along both axes.
        let integral = |kernel: &[f32]| kernel.iter().sum::<f32>().powi(2);

        let (achromatic, red_green) = (gaussian(ACHROMATIC), gaussian(RED_GREEN));
        let (achromatic_sum, red_green_sum) = (integral(&achromatic), integral(&red_green));
        let blue_yellow = BLUE_YELLOW.map(gaussian);
        let blue_yellow_sum = blue_yellow.iter().map(|kernel| integral(kernel)).sum();
        Self {
            achromatic: normalized(achromatic, achromatic_sum),
            red_green: normalized(red_green, red_green_sum),
            blue_yellow: blue_yellow.map(|kernel| normalized(kernel, blue_yellow_sum)),
        }
    }

    /// Filters every channel by its own sensitivity.
    fn apply(&self, image: &YCxCz) -> YCxCz {
        let both_axes =
            |plane: &Plane, kernel: &[f32]| plane.filter_rows(kernel).filter_columns(kernel);
        YCxCz {
            y: both_axes(&image.y, &self.achromatic),
            cx: both_axes(&image.cx, &self.red_green),
            cz: Plane::sum(
                &both_axes(&image.cz, &self.blue_yellow[0]),
                &both_axes(&image.cz, &self.blue_yellow[1]),
            ),
        }
    }
}

/// Detectors of edges and points: a Gaussian and its first two derivatives.
struct FeatureKernel {
    /// Sums to 1.
    gaussian: Vec<f32>,
    /// First derivative; its positive and its negative weights sum to 1 and -1.
    edge: Vec<f32>,
    /// Second derivative; its positive and its negative weights sum to 1 and -1.
    point: Vec<f32>,
}

impl FeatureKernel {
    /// Kernels of three standard deviations.
    fn new(pixels_per_degree: f32) -> Self {
        let sigma = 0.5 * FEATURE_WIDTH_DEGREES * pixels_per_degree;
        let radius = (3.0 * sigma).ceil() as i32;
        let gaussian = |x: f32| (-x * x / (2.0 * sigma * sigma)).exp();
        Self {
            gaussian: balanced(taps(radius, gaussian)),
            edge: balanced(taps(radius, |x| -x * gaussian(x))),
            point: balanced(taps(radius, |x| {
                (x * x / (sigma * sigma) - 1.0) * gaussian(x)
            })),
        }
    }
}

/// Samples `f` at the integers from `-radius` to `radius`.
fn taps(radius: i32, f: impl Fn(f32) -> f32) -> Vec<f32> {
    (-radius..=radius).map(|x| f(x as f32)).collect()
}

/// Scales positive weights to sum to 1 and negative ones to sum to -1.
fn balanced(mut kernel: Vec<f32>) -> Vec<f32> {
    let positive: f32 = kernel.iter().filter(|weight| **weight > 0.0).sum();
    let negative: f32 = kernel.iter().filter(|weight| **weight < 0.0).sum();
    for weight in &mut kernel {
        if *weight != 0.0 {
            *weight /= if *weight > 0.0 { positive } else { -negative };
        }
    }
    kernel
}

/// One channel, in raster order.
struct Plane {
    width: usize,
    height: usize,
    values: Vec<f32>,
}

impl Plane {
    /// Applies `f` to every value.
    fn map(&self, f: impl Fn(f32) -> f32 + Sync) -> Self {
        self.with_values(self.values.par_iter().map(|&v| f(v)).collect())
    }

    /// Value by value sum of two planes of the same size.
    fn sum(a: &Self, b: &Self) -> Self {
        a.zip(b, |a, b| a + b)
    }

    /// Value by value Euclidean norm of the vector (`x`, `y`).
    fn norm(x: &Self, y: &Self) -> Self {
        x.zip(y, |x, y| (x * x + y * y).sqrt())
    }

    /// Correlates every row with a kernel of odd length.
    fn filter_rows(&self, kernel: &[f32]) -> Self {
        let radius = kernel.len() / 2;
        self.rows(|y, out| {
            let row = &self.values[y * self.width..][..self.width];
            // A padded copy leaves the inner loop without bounds to clamp, so that it vectorises.
            let mut padded = Vec::with_capacity(row.len() + 2 * radius);
            padded.resize(radius, row[0]);
            padded.extend_from_slice(row);
            padded.resize(row.len() + 2 * radius, row[row.len() - 1]);
            for (tap, &weight) in kernel.iter().enumerate() {
                accumulate(out, weight, &padded[tap..]);
            }
        })
    }

    /// Correlates every column with a kernel of odd length.
    fn filter_columns(&self, kernel: &[f32]) -> Self {
        let radius = kernel.len() / 2;
        self.rows(|y, out| {
            for (tap, &weight) in kernel.iter().enumerate() {
                let source = (y + tap).saturating_sub(radius).min(self.height - 1);
                accumulate(out, weight, &self.values[source * self.width..]);
            }
        })
    }

    /// A plane of the same size whose rows, zero at first, are filled by `fill(y, row)`.
    fn rows(&self, fill: impl Fn(usize, &mut [f32]) + Sync) -> Self {
        let mut values = vec![0.0; self.values.len()];
        values
            .par_chunks_mut(self.width.max(1))
            .enumerate()
            .for_each(|(y, row)| fill(y, row));
        self.with_values(values)
    }

    fn zip(&self, other: &Self, f: impl Fn(f32, f32) -> f32 + Sync) -> Self {
        let pairs = self.values.par_iter().zip(&other.values);
        self.with_values(pairs.map(|(&a, &b)| f(a, b)).collect())
    }

    fn with_values(&self, values: Vec<f32>) -> Self {
        Self {
            width: self.width,
            height: self.height,
            values,
        }
    }
}

/// Adds `weight` times the first values of `source` to `out`.
fn accumulate(out: &mut [f32], weight: f32, source: &[f32]) {
    for (out, source) in out.iter_mut().zip(source) {
        *out += weight * source;
    }
}

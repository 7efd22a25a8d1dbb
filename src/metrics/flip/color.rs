//! Colour spaces of FLIP: sRGB to YCxCz, and the perceived distance of two filtered colours.

use bevy_wavelet_tex::codec::color::linear_from_srgb;
use image::RgbImage;
use rayon::prelude::*;

use super::plane::Plane;

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
pub(super) struct YCxCz {
    pub y: Plane,
    pub cx: Plane,
    pub cz: Plane,
}

impl YCxCz {
    /// Decodes an sRGB image.
    pub fn new(image: &RgbImage) -> Self {
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
    pub fn at(&self, i: usize) -> [f32; 3] {
        [self.y.values[i], self.cx.values[i], self.cz.values[i]]
    }
}

/// The remapped colour distance, with its scale.
pub(super) struct ColorDistance {
    largest: f32,
}

impl ColorDistance {
    /// The scale is set by the two most distant colours of sRGB, green and blue.
    pub fn new() -> Self {
        let [green, blue] = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(hunt_lab);
        Self {
            largest: hyab(green, blue).powf(DISTANCE_EXPONENT),
        }
    }

    /// Colour error, 0 to 1, of two filtered YCxCz colours.
    pub fn between(&self, a: [f32; 3], b: [f32; 3]) -> f32 {
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

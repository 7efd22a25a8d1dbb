//! The axes of colour: what luma and the two planes of chroma stand for.
//!
//! They are those of YCoCg, or fitted to the image. Along fitted axes, which are its principal ones, the
//! two planes of half the size have the least energy that they can have. That gains most where an image
//! has saturated edges of one hue, or channels that have little to do with colour.

#[cfg(feature = "encode")]
use glam::{DMat3, DVec3, Vec3};
#[cfg(feature = "encode")]
use rayon::prelude::*;

#[cfg(feature = "encode")]
use super::source::Pixels;

/// RGB as sums of luma and two planes of chroma.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColorAxes {
    /// RGB of one unit of luma and of each plane of chroma.
    pub rgb: [[f32; 3]; 3],
}

/// Largest magnitude of an entry; larger values in a file are damage.
const LARGEST: f32 = 2.0;

impl ColorAxes {
    /// The axes of YCoCg, as in [`color`](super::color).
    pub const YCOCG: Self = Self {
        rgb: [[1.0, 1.0, 1.0], [0.5, 0.0, -0.5], [-0.5, 0.5, -0.5]],
    };

    /// Returns whether a decoder can use them.
    pub fn is_valid(&self) -> bool {
        let mut entries = self.rgb.as_flattened().iter();
        entries.all(|v| v.abs() <= LARGEST)
    }

    /// Returns whether the axes are those of YCoCg, for which decoders have code of their own.
    pub fn are_ycocg(&self) -> bool {
        *self == Self::YCOCG
    }

    /// RGB of a pixel, without clamping.
    pub fn rgb_of(&self, planes: [f32; 3]) -> [f32; 3] {
        std::array::from_fn(|c| (0..3).map(|plane| planes[plane] * self.rgb[plane][c]).sum())
    }
}

#[cfg(feature = "encode")]
impl ColorAxes {
    /// The principal axes of a covariance of RGB, or `None` where there is none. Luma has the scale of
    /// gray.
    pub(super) fn fitted(covariance: &DMat3) -> Option<Self> {
        let first = principal_axis(covariance)?;
        let along = first.dot(*covariance * first);
        let across = *covariance - along * squared(first);
        // Where all colours lie on a line, any two axes across it are as good.
        let second = principal_axis(&across).unwrap_or_else(|| first.any_orthonormal_vector());
        let axes = [3.0f64.sqrt() * first, second, first.cross(second)];
        Some(Self {
            rgb: axes.map(|axis| axis.as_vec3().to_array()),
        })
    }

    /// RGB of one unit of luma and of each plane of chroma.
    fn columns(&self) -> [DVec3; 3] {
        self.rgb.map(|axis| Vec3::from(axis).as_dvec3())
    }

    /// The weights of RGB in luma and in each plane of chroma: the rows of the inverse matrix.
    pub(super) fn weights(&self) -> [[f32; 3]; 3] {
        let [luma, first, second] = self.columns();
        let rows = DMat3::from_cols(luma, first, second).inverse().transpose();
        rows.as_mat3().to_cols_array_2d()
    }

    /// The part of the energy of a covariance that is in chroma, in units of RGB.
    pub(super) fn chroma_energy(&self, covariance: &DMat3) -> f64 {
        let planes = self
            .weights()
            .into_iter()
            .skip(1)
            .zip(self.chroma_weights());
        let energy = |(plane, weight): ([f32; 3], f32)| {
            let plane = Vec3::from(plane).as_dvec3();
            f64::from(weight) * plane.dot(*covariance * plane)
        };
        planes.map(energy).sum()
    }

    /// Amount by which luma should be raised where a plane of chroma is too large by 1: the least-squares
    /// solution over R, G and B.
    pub(super) fn luma_correction(&self, chroma: usize) -> f32 {
        let [luma, planes @ ..] = self.columns();
        (-luma.dot(planes[chroma]) / luma.length_squared()) as f32
    }

    /// Weights of the squared errors of chroma in the squared error of RGB, given that luma compensates a
    /// part of them (see [`Self::luma_correction`]).
    pub(super) fn chroma_weights(&self) -> [f32; 2] {
        let [luma, planes @ ..] = self.columns();
        planes.map(|chroma| chroma.reject_from(luma).length_squared() as f32)
    }
}

/// The covariance of what the mean of `1 << halvings` pixels squared does not have: what a plane loses
/// at a smaller size. Beyond the last whole square, pixels are left out.
#[cfg(feature = "encode")]
pub(super) fn detail_covariance(pixels: &Pixels<'_>, size: [u32; 2], halvings: u32) -> DMat3 {
    let side = 1usize << halvings;
    let [width, height] = size.map(|s| s as usize);
    let of_square = |left: usize, top: usize| -> DMat3 {
        let pixel = |i: usize| {
            let [r, g, b, _] = pixels.get((top + i / side) * width + left + i % side);
            Vec3::new(r, g, b).as_dvec3()
        };
        let count = side * side;
        let mean = (0..count).map(pixel).sum::<DVec3>() / count as f64;
        (0..count).map(|i| squared(pixel(i) - mean)).sum()
    };
    let of_row = |row: usize| -> DMat3 {
        let squares = 0..width / side;
        squares.map(|i| of_square(i * side, row * side)).sum()
    };
    let rows: Vec<DMat3> = (0..height / side).into_par_iter().map(of_row).collect();
    rows.into_iter().sum()
}

/// The products of the components of a vector.
#[cfg(feature = "encode")]
fn squared(v: DVec3) -> DMat3 {
    DMat3::from_cols(v * v.x, v * v.y, v * v.z)
}

/// The first principal axis, of unit length, by power iteration. `None` where there is no energy.
#[cfg(feature = "encode")]
fn principal_axis(covariance: &DMat3) -> Option<DVec3> {
    // The column of the largest energy is not orthogonal to the axis.
    let largest = covariance.diagonal().max_position();
    if covariance.col(largest)[largest] < 1e-9 {
        return None;
    }
    let start = covariance.col(largest).normalize();
    Some((0..64).fold(start, |axis, _| (*covariance * axis).normalize()))
}

#[cfg(all(test, feature = "encode"))]
mod tests {
    use super::*;
    use crate::codec::color::{YCoCg, rgb_from_ycocg, ycocg_from_rgb};

    const PIXEL: [f32; 3] = [0.7, 0.1, 0.4];

    fn assert_close(a: [f32; 3], b: [f32; 3]) {
        let close = a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-5);
        assert!(close, "{a:?} {b:?}");
    }

    #[test]
    fn those_of_ycocg_are_its_transform() {
        let axes = ColorAxes::YCOCG;
        let YCoCg { y, co, cg } = ycocg_from_rgb(PIXEL);
        let planes = axes
            .weights()
            .map(|w| (0..3).map(|c| w[c] * PIXEL[c]).sum());
        assert_close(planes, [y, co, cg]);
        assert_close(axes.rgb_of(planes), rgb_from_ycocg(YCoCg { y, co, cg }));
    }

    #[test]
    fn the_correction_of_luma_is_the_best() {
        let others = [[1.2, 0.4, 0.1], [0.3, -0.6, 0.9], [0.1, 0.8, 0.5]];
        for axes in [ColorAxes::YCOCG, ColorAxes { rgb: others }] {
            for chroma in 0..2 {
                let error = |raised: f32| -> f32 {
                    let mut planes = [raised, 0.0, 0.0];
                    planes[1 + chroma] = 0.3;
                    axes.rgb_of(planes).iter().map(|v| v * v).sum()
                };
                let best = 0.3 * axes.luma_correction(chroma);
                assert!(error(best) < error(best - 0.01) && error(best) < error(best + 0.01));
                let weight = axes.chroma_weights()[chroma];
                assert!((error(best) / 0.09 - weight).abs() < 1e-5);
            }
        }
        assert!((ColorAxes::YCOCG.luma_correction(1) - 1.0 / 6.0).abs() < 1e-6);
    }

    #[test]
    fn fitted_axes_are_orthogonal_and_follow_the_colours() {
        // Colours on a line from black to orange, and a little green beside it.
        let pixel = |i: u32| {
            let t = (i * 7 % 64) as u8;
            [
                3 * t,
                2 * t + if i.is_multiple_of(2) { 3 } else { 0 },
                t / 2,
            ]
        };
        let pixels: Vec<[u8; 3]> = (0..256).map(pixel).collect();
        let covariance = detail_covariance(&Pixels::Rgb8(&pixels), [16, 16], 1);
        let axes = ColorAxes::fitted(&covariance).expect("colours that differ");
        assert!(axes.is_valid() && !axes.are_ycocg());
        let ycocg = ColorAxes::YCOCG.chroma_energy(&covariance);
        assert!(axes.chroma_energy(&covariance) < 0.1 * ycocg);
        let [luma, first, second] = axes.columns();
        for (a, b) in [(luma, first), (luma, second), (first, second)] {
            assert!(a.dot(b).abs() < 1e-6);
        }
        let along = luma.dot(DVec3::new(3.0, 2.0, 0.5).normalize()).abs() / 3.0f64.sqrt();
        assert!(along > 0.999, "{along}");
        // One line of colours alone, and none.
        let line = ColorAxes::fitted(&squared(DVec3::ONE)).expect("grays");
        assert!(line.is_valid() && line.weights().as_flattened().iter().all(|v| v.is_finite()));
        assert_eq!(ColorAxes::fitted(&DMat3::ZERO), None);
    }
}

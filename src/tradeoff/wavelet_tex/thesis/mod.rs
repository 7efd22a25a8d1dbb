//! The thesis's Tables 3.1 and 3.3, rebuilt with this code. The thesis measured Lena; here they are
//! measured on each image.

mod correlation;
mod lossless;
mod spaces;
mod wavelets;

use bevy_wavelet_tex::codec::{
    color::ycocg_from_rgb, haar::Transform, plane::Plane, quality::psnr_of,
};
use image::RgbImage;

use self::{spaces::Space, wavelets::Wavelet};
use super::published::{TABLE_3_1, TABLE_3_3};
use crate::record::Measurement;

/// The rows of Table 3.3, each with the candidates for its parameter.
const WAVELETS: [(&str, &[Wavelet]); 4] = [
    ("Haar", &[Wavelet::Real(Transform::Haar)]),
    ("PLHaar", &[Wavelet::PlHaar]),
    ("S-transform", &[Wavelet::S]),
    ("PI-Haar", &PARTLY_INVERTED),
];

const PARTLY_INVERTED: [Wavelet; 5] = [
    partly_inverted(0.2),
    partly_inverted(0.4),
    partly_inverted(0.6),
    partly_inverted(0.8),
    partly_inverted(1.0),
];

const fn partly_inverted(w: f32) -> Wavelet {
    Wavelet::Real(Transform::PartiallyInvertedHaar { w })
}

/// The rows of an image; none where it is smaller than 16 x 16 pixels.
pub(super) fn rows(scene: &str, image: &RgbImage) -> Vec<Measurement> {
    if image.width() < 16 || image.height() < 16 {
        return Vec::new();
    }
    let cropped = Cropped::new(image);
    let row = |setting: &str, reference: &str| Measurement {
        scene: scene.into(),
        setting: setting.into(),
        reference: reference.into(),
        ..Measurement::default()
    };
    let cases = correlation::CASES.iter().zip(cropped.correlation());
    let errors = cases.map(|((name, ..), mse)| Measurement {
        mse: Some(mse),
        ..row(name, TABLE_3_1)
    });
    let wavelets = WAVELETS.map(|(name, family)| (name, Space::YCoCgR, family));
    // YCoCg-R with PI-Haar is among the wavelets.
    let spaces =
        [Space::YCoCg, Space::YCbCr].map(|space| (space.name(), space, &PARTLY_INVERTED[..]));
    let psnrs = wavelets.into_iter().chain(spaces);
    let psnrs = psnrs.map(|(name, space, family)| Measurement {
        psnr_db: Some(cropped.psnr(space, family)).filter(|psnr| psnr.is_finite()),
        ..row(name, TABLE_3_3)
    });
    errors.chain(psnrs).collect()
}

/// A picture that is cropped to multiples of 16, so that planes of half its size have whole blocks.
struct Cropped {
    size: [usize; 2],
    pixels: Vec<[u8; 3]>,
}

impl Cropped {
    fn new(image: &RgbImage) -> Self {
        let size = [image.width(), image.height()].map(|side| side as usize / 16 * 16);
        let pixels = Plane::positions(size.map(|s| s as u32));
        Self {
            size,
            pixels: pixels.map(|(x, y)| image.get_pixel(x, y).0).collect(),
        }
    }

    /// Measures Table 3.1 for luma, in the order of [`correlation::CASES`].
    fn correlation(&self) -> [f64; 4] {
        let [width, height] = self.size;
        let luma: Vec<f32> = self
            .pixels
            .iter()
            .map(|p| ycocg_from_rgb(p.map(f32::from)).y.round())
            .collect();
        let at = |x: usize, y: usize| luma[y * width + x];
        let size = [width / 2, height / 2];
        let quads: Vec<[f32; 4]> = (0..size[0] * size[1])
            .map(|i| {
                let (x, y) = (2 * (i % size[0]), 2 * (i / size[0]));
                [at(x, y), at(x + 1, y), at(x, y + 1), at(x + 1, y + 1)]
            })
            .collect();
        let size = size.map(|s| s as u32);
        correlation::CASES.map(|(_, transform, together)| {
            correlation::error_of_first(transform, together, &quads, size)
        })
    }

    /// PSNR of the picture at 3 bits per pixel, as in the thesis: luma at full size, chromas at
    /// half the size, each as a wavelet plane of 8 bits in BC3.
    fn psnr(&self, space: Space, family: &[Wavelet]) -> f64 {
        let [width, height] = self.size;
        let planes: [Vec<i32>; 3] =
            std::array::from_fn(|c| self.pixels.iter().map(|p| space.forward(*p)[c]).collect());
        let luma = wavelets::through(family, &planes[0], self.size);
        let small = [width / 2, height / 2];
        let [first, second] = [1, 2].map(|c| {
            let mean = |i: usize| {
                let first = i / small[0] * 2 * width + i % small[0] * 2;
                let quad = [0, 1, width, width + 1].map(|offset| planes[c][first + offset]);
                (quad.iter().sum::<i32>() as f32 / 4.0).round() as i32
            };
            let means: Vec<i32> = (0..small[0] * small[1]).map(mean).collect();
            signed_through(family, &means, small)
        });
        let error: f64 = (0..width * height)
            .map(|i| {
                let half = i / width / 2 * small[0] + i % width / 2;
                let rgb = space.inverse([luma[i], first[half], second[half]]);
                let pairs = rgb.iter().zip(self.pixels[i]);
                let errors = pairs.map(|(a, b)| a.round().clamp(0.0, 255.0) - f32::from(b));
                errors.map(|e| f64::from(e * e)).sum::<f64>()
            })
            .sum();
        psnr_of(error / (3 * width * height) as f64)
    }
}

/// Encodes and decodes a plane of signed values in blocks of 8 bits, in 256 steps of 1 where that
/// covers the range, otherwise in steps of 2 (thesis section 3.6.1).
fn signed_through(family: &[Wavelet], plane: &[i32], size: [usize; 2]) -> Vec<f32> {
    let least = plane.iter().copied().min().unwrap_or(0);
    let most = plane.iter().copied().max().unwrap_or(0);
    let step = if most - least <= 255 { 1 } else { 2 };
    let codes: Vec<i32> = plane.iter().map(|v| (v - least) / step).collect();
    let back = wavelets::through(family, &codes, size);
    back.iter()
        .map(|v| v * step as f32 + least as f32)
        .collect()
}

//! Prediction of the detail bands from the neighbouring values of the low band.
//!
//! Images are mostly smooth: where the low band falls from left to right, the left of the two
//! columns of pixels is brighter than the right one. With `m` the low band around a position,
//! `HL = 2 a (m[-1, 0] - m[1, 0])`, `LH` the same in y, and
//! `HH = 2 a^2 (m[-1, -1] - m[1, -1] - m[-1, 1] + m[1, 1])`. Together they are the separable kernel
//! `(a, 1, -a)` applied in x and y. 1/8 continues a parabola exactly; for photographs about 1/6 is
//! best.
//!
//! The decoder has the low band anyway. It is coded independently of the details (in alpha, for
//! example), so the encoder predicts from the decoded low band and stores only the residual. That
//! gains 0.7 dB on the Kodak images in gray at 2 bits per pixel without any bits
//! (`Method::OneFetch` is the same codec without prediction; `wavelet-tex bench --method` measures
//! both).

use super::{haar::Details, plane::Plane};

/// The slopes of the low band: the prediction for a `predictor` of 1. HL and LH scale with the
/// predictor, HH with its square.
pub fn slopes(low_band: &Plane, x: u32, y: u32) -> Details {
    let (left, right) = (x.saturating_sub(1), x + 1);
    let (above, below) = (y.saturating_sub(1), y + 1);
    let m = |x, y| low_band.clamped(x, y);
    [
        2.0 * (m(left, y) - m(right, y)),
        2.0 * (m(x, above) - m(x, below)),
        2.0 * (m(left, above) - m(right, above) - m(left, below) + m(right, below)),
    ]
}

/// The prediction of HL, LH and HH. Beyond the edges the outermost values of the low band are
/// repeated.
pub fn predicted(low_band: &Plane, x: u32, y: u32, predictor: f32) -> Details {
    if predictor == 0.0 {
        return [0.0; 3];
    }
    let [hl, lh, hh] = slopes(low_band, x, y);
    [predictor * hl, predictor * lh, predictor * predictor * hh]
}

/// The predictor that leaves the residual of the least energy, by least squares over HL and LH.
pub fn best_predictor(slopes_and_details: impl Iterator<Item = (Details, Details)>) -> f32 {
    predictor_of(products(slopes_and_details))
}

/// The sums of the products of slopes and details, and of the squares of slopes, over HL and LH.
pub(super) fn products(slopes_and_details: impl Iterator<Item = (Details, Details)>) -> [f64; 2] {
    let (mut both, mut square) = (0.0f64, 0.0f64);
    for (slopes, details) in slopes_and_details {
        for c in 0..2 {
            both += f64::from(slopes[c]) * f64::from(details[c]);
            square += f64::from(slopes[c]) * f64::from(slopes[c]);
        }
    }
    [both, square]
}

/// The best predictor by these sums.
pub(super) fn predictor_of([both, square]: [f64; 2]) -> f32 {
    if square > 0.0 {
        (both / square).clamp(-0.5, 0.5) as f32
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codec::haar::haar;

    /// The low band and the details of a picture of `size` quads.
    fn quads(size: [u32; 2], value: impl Fn(f32, f32) -> f32 + Sync) -> (Plane, Vec<Details>) {
        let pixels = Plane::from_fn(size.map(|s| 2 * s), |x, y| value(x as f32, y as f32));
        let low_band = Plane::from_fn(size, |x, y| haar(pixels.quad(x, y)).ll / 2.0);
        let details = (0..size[1])
            .flat_map(|y| (0..size[0]).map(move |x| (x, y)))
            .map(|(x, y)| haar(pixels.quad(x, y)).details)
            .collect();
        (low_band, details)
    }

    #[test]
    fn a_parabola_is_predicted_exactly_by_an_eighth() {
        // The mean of a parabola over a quad differs from the parabola by a constant; the product
        // of two has a cross term.
        let (low_band, details) = quads([6, 6], |x, y| {
            (x * x - 3.0 * x + 1.0) * (0.5 * y + 2.0) / 64.0
        });
        for y in 1..5 {
            for x in 1..5 {
                let expected = details[(y * 6 + x) as usize];
                let actual = predicted(&low_band, x, y, 0.125);
                for c in 0..3 {
                    assert!(
                        (actual[c] - expected[c]).abs() < 1e-4,
                        "{actual:?} {expected:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn least_squares_finds_the_slope_and_flat_images_need_none() {
        let (low_band, details) = quads([8, 8], |x, y| x * x / 100.0 + 0.05 * y);
        let inner = (1..7u32).flat_map(|y| (1..7u32).map(move |x| (x, y)));
        let pairs = inner.map(|(x, y)| (slopes(&low_band, x, y), details[(y * 8 + x) as usize]));
        assert!((best_predictor(pairs) - 0.125).abs() < 1e-4);
        assert_eq!(best_predictor([([0.0; 3], [1.0; 3])].into_iter()), 0.0);
    }
}

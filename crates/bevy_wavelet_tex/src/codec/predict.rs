//! What the means of neighbouring 2 x 2 pixels foretell of the details between them.
//!
//! An image mostly goes on as it goes: where the mean falls from left to right, so do the two
//! columns of pixels in between. With `m` the means around one,
//! `HL = 2 a (m[-1, 0] - m[1, 0])`, `LH` the same in y, and
//! `HH = 2 a^2 (m[-1, -1] - m[1, -1] - m[-1, 1] + m[1, 1])`, which together is the separable kernel
//! `(a, 1, -a)` applied in x and y: 1/8 would continue a parabola, photographs like about 1/6.
//!
//! The decoder has the means anyway. They are stored on their own (in alpha, say), so the encoder
//! predicts from what the decoder will have and stores only what is left: 0.7 dB on the Kodak images
//! in gray at 2 bits per pixel for no bits (`Method::OneFetch` is the same without; `wavelet-tex bench
//! FOLDER --study` measures both).

use super::{haar::Details, plane::Plane};

/// The prediction for `predictor` 1, by which HL and LH are to be multiplied and, twice, HH.
pub fn slopes(means: &Plane, x: u32, y: u32) -> Details {
    let (left, right) = (x.saturating_sub(1), x + 1);
    let (above, below) = (y.saturating_sub(1), y + 1);
    let m = |x, y| means.clamped(x, y);
    [
        2.0 * (m(left, y) - m(right, y)),
        2.0 * (m(x, above) - m(x, below)),
        2.0 * (m(left, above) - m(right, above) - m(left, below) + m(right, below)),
    ]
}

/// HL, LH and HH as the means foretell them; at the edges the outermost means go on.
pub fn predicted(means: &Plane, x: u32, y: u32, predictor: f32) -> Details {
    if predictor == 0.0 {
        return [0.0; 3];
    }
    let [hl, lh, hh] = slopes(means, x, y);
    [predictor * hl, predictor * lh, predictor * predictor * hh]
}

/// The predictor that leaves the least energy, by least squares over HL and LH.
pub fn best_predictor(slopes_and_details: impl Iterator<Item = (Details, Details)>) -> f32 {
    let (mut both, mut square) = (0.0f64, 0.0f64);
    for (slopes, details) in slopes_and_details {
        for c in 0..2 {
            both += f64::from(slopes[c]) * f64::from(details[c]);
            square += f64::from(slopes[c]) * f64::from(slopes[c]);
        }
    }
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

    /// Means and details of a picture of `size` quads.
    fn quads(size: [u32; 2], value: impl Fn(f32, f32) -> f32) -> (Plane, Vec<Details>) {
        let pixels = Plane::from_fn(size.map(|s| 2 * s), |x, y| value(x as f32, y as f32));
        let means = Plane::from_fn(size, |x, y| haar(pixels.quad(x, y)).ll / 2.0);
        let details = (0..size[1])
            .flat_map(|y| (0..size[0]).map(move |x| (x, y)))
            .map(|(x, y)| haar(pixels.quad(x, y)).details)
            .collect();
        (means, details)
    }

    #[test]
    fn a_parabola_is_foretold_exactly_by_an_eighth() {
        // The mean over a quad of a parabola differs from it by a constant; its product has a cross term.
        let (means, details) = quads([6, 6], |x, y| {
            (x * x - 3.0 * x + 1.0) * (0.5 * y + 2.0) / 64.0
        });
        for y in 1..5 {
            for x in 1..5 {
                let wanted = details[(y * 6 + x) as usize];
                let found = predicted(&means, x, y, 0.125);
                for c in 0..3 {
                    assert!((found[c] - wanted[c]).abs() < 1e-4, "{found:?} {wanted:?}");
                }
            }
        }
    }

    #[test]
    fn least_squares_finds_the_slope_and_flat_images_need_none() {
        let (means, details) = quads([8, 8], |x, y| x * x / 100.0 + 0.05 * y);
        let inner = (1..7u32).flat_map(|y| (1..7u32).map(move |x| (x, y)));
        let pairs = inner.map(|(x, y)| (slopes(&means, x, y), details[(y * 8 + x) as usize]));
        assert!((best_predictor(pairs) - 0.125).abs() < 1e-4);
        assert_eq!(best_predictor([([0.0; 3], [1.0; 3])].into_iter()), 0.0);
    }
}

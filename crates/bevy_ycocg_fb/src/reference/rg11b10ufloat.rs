//! Rounding, with dither, to three floats without sign, of 11, 11 and 10 bits.
//!
//! All three have 5 bits of exponent; red and green have 6 bits of mantissa, blue has 5. A specification allows
//! a target to round to either neighbour, so the shader rounds by itself: up where the part below the last bit is
//! at least a threshold, which depends on the pixel. The mean over pixels is the colour itself.

use super::pack::sanitized;

/// Bits of the mantissa of red, green and blue.
const MANTISSA_BITS: [u32; 3] = [6, 6, 5];

/// Thresholds of red, green and blue differ by a third of their range, so that their sum is smoother.
const CHANNEL_OFFSETS: [u32; 3] = [0, 0x5555_5555, 0xaaaa_aaaa];

/// Exponent of the smallest normal number.
const MIN_EXPONENT: i32 = -14;

/// Returns the threshold of a pixel, in units of 2^-32: the additive sequence of the plastic number, whose values
/// in any neighbourhood are spread evenly (M. Roberts, *The Unreasonable Effectiveness of Quasirandom Sequences*,
/// 2018).
pub fn threshold(x: u32, y: u32) -> u32 {
    x.wrapping_mul(0xc13f_a9a9)
        .wrapping_add(y.wrapping_mul(0x91e1_0da5))
}

/// Returns the largest value of a channel with this number of mantissa bits.
fn largest(mantissa_bits: u32) -> f32 {
    (2.0 - 1.0 / (1 << mantissa_bits) as f32) * 2f32.powi(15)
}

/// Rounds a scene-linear colour as the shader of the pixel at this position does.
pub fn dithered(rgb: [f32; 3], x: u32, y: u32) -> [f32; 3] {
    let threshold = threshold(x, y);
    let rgb = sanitized(rgb);
    std::array::from_fn(|i| {
        let threshold = threshold.wrapping_add(CHANNEL_OFFSETS[i]);
        rounded(rgb[i], threshold, MANTISSA_BITS[i])
    })
}

/// Rounds a value of 0 or more up or down. `threshold` is in units of 2^-32 of the distance between the two.
fn rounded(value: f32, threshold: u32, mantissa_bits: u32) -> f32 {
    let smallest_normal = 2f32.powi(MIN_EXPONENT);
    if value < smallest_normal {
        let step = smallest_normal / (1 << mantissa_bits) as f32;
        // 16 bits of the threshold, so that the sum is exact.
        let threshold = (threshold >> 16) as f32 / (1 << 16) as f32;
        return (value / step + threshold).floor() * step;
    }
    let dropped = f32::MANTISSA_DIGITS - 1 - mantissa_bits;
    let bits = value.to_bits() + (threshold >> (32 - dropped));
    f32::from_bits(bits >> dropped << dropped).min(largest(mantissa_bits))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether a value is one of those that a channel stores.
    fn is_stored(value: f32, mantissa_bits: u32) -> bool {
        let step = 2f32.powi(value.max(1e-30).log2().floor().max(-14.0) as i32)
            / (1 << mantissa_bits) as f32;
        value >= 0.0 && value <= largest(mantissa_bits) && (value / step).fract() == 0.0
    }

    #[test]
    fn what_is_stored_is_one_of_the_two_neighbours() {
        for i in 0..4000_u32 {
            let value = 2f32.powf(i as f32 / 100.0 - 22.0);
            for (channel, stored) in dithered([value; 3], i, 7 * i).into_iter().enumerate() {
                let bits = MANTISSA_BITS[channel];
                assert!(is_stored(stored, bits), "{value} gives {stored}");
                let step = (value.min(largest(bits)) / (1 << bits) as f32).max(2f32.powi(-19));
                let expected = value.min(largest(bits));
                assert!((stored - expected).abs() <= step, "{value} gives {stored}");
                assert_eq!(rounded(stored, u32::MAX, bits), stored, "{value}");
            }
        }
    }

    #[test]
    fn the_mean_over_pixels_is_the_color() {
        for value in [0.18, 0.7301, 1.9, 300.3, 1e-5, 3e-7] {
            let mut sums = [0.0_f64; 3];
            for (x, y) in (0..64 * 64).map(|i| (i % 64 + 13, i / 64 + 400)) {
                for (sum, stored) in sums.iter_mut().zip(dithered([value; 3], x, y)) {
                    *sum += f64::from(stored);
                }
            }
            for (sum, bits) in sums.iter().zip(MANTISSA_BITS) {
                let step = f64::from(value).max(2f64.powi(-14)) / f64::from(1 << bits);
                let error = (sum / 4096.0 - f64::from(value)).abs();
                // The error of 4096 random thresholds would be 0.008 steps.
                assert!(error < 0.003 * step, "{value}: {} steps", error / step);
            }
        }
    }

    #[test]
    fn values_that_are_not_stored() {
        let stored = |value| dithered([value; 3], 5, 9);
        assert_eq!(stored(f32::NAN), [0.0; 3]);
        assert_eq!(stored(-1.0), [0.0; 3]);
        assert_eq!(stored(0.0), [0.0; 3]);
        let most = MANTISSA_BITS.map(largest);
        assert_eq!(most, [65024.0, 65024.0, 64512.0]);
        assert_eq!(stored(f32::INFINITY), most);
        assert_eq!(stored(65100.0), most);
    }

    /// The sixteenths of the range have nearly as many thresholds each, in any block of 16 x 16 pixels.
    #[test]
    fn thresholds_are_spread_evenly() {
        for corner in [[0, 0], [1918, 1079], [7, 40_000]] {
            let mut counts = [0_i32; 16];
            for i in 0..256 {
                counts[threshold(corner[0] + i % 16, corner[1] + i / 16) as usize >> 28] += 1;
            }
            // That of random thresholds would be 240 on average.
            let variation: i32 = counts.iter().map(|count| (count - 16).pow(2)).sum();
            assert!(variation < 120, "{variation}: {counts:?}");
        }
    }
}

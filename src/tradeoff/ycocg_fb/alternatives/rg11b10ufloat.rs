//! Three unsigned floats of 11, 11 and 10 bits: what a user would pick today.
//!
//! All have 5 bits of exponent; red and green have 6 of mantissa, blue 5. Conversion rounds to
//! nearest, ties to even, as the hardware that we know of does; specifications allow truncation too,
//! which would double the error.

use super::super::frame::Frame;

/// Stores and loads a scene-linear picture.
pub fn rg11b10ufloat(frame: &Frame) -> Frame {
    Frame::from_fn(frame.size, |x, y| {
        let [r, g, b] = frame.at(x, y);
        [rounded(r, 6), rounded(g, 6), rounded(b, 5)]
    })
}

/// The nearest unsigned float with 5 bits of exponent and so many of mantissa.
fn rounded(value: f32, mantissa_bits: i32) -> f32 {
    if value.is_nan() || value <= 0.0 {
        return 0.0;
    }
    let largest = (2.0 - 2f32.powi(-mantissa_bits)) * 2f32.powi(15);
    // Below 2^-14 the steps stay those of 2^-14.
    let exponent = (value.to_bits() >> 23) as i32 - 127;
    let step = 2f32.powi(exponent.clamp(-14, 15) - mantissa_bits);
    ((value / step).round_ties_even() * step).min(largest)
}

#[cfg(test)]
mod tests {
    use super::rounded;

    #[test]
    fn small_floats_of_every_kind() {
        for (value, bits, expected) in [
            (1.0, 6, 1.0),
            (1.0 + 1.0 / 128.0, 6, 1.0),
            (1.0 + 3.0 / 128.0, 6, 1.0 + 2.0 / 64.0),
            (65504.0, 6, 65024.0),
            (1e9, 5, 64512.0),
            (2f32.powi(-20), 6, 2f32.powi(-20)),
            (2f32.powi(-22), 6, 0.0),
            (-1.0, 6, 0.0),
            (f32::NAN, 6, 0.0),
        ] {
            assert_eq!(rounded(value, bits), expected, "{value}");
        }
    }
}

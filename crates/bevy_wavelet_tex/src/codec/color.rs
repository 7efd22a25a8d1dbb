//! The YCoCg-R transform (thesis section 3.3.1, Malvar and Sullivan 2003) and the sRGB transfer
//! function.
//!
//! The integer transform rounds its halves down so that 8-bit channels survive a round trip. Here
//! the planes are real numbers until the block encoder quantises them, so the same lifting steps
//! run without rounding and are exact.

/// Luma and chroma of one pixel. For RGB in `[0, 1]`, `y` is in `[0, 1]`, `co` and `cg` are in
/// `[-1, 1]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct YCoCg {
    /// Luma, `(R + 2 G + B) / 4`.
    pub y: f32,
    /// Orange chroma, `R - B`.
    pub co: f32,
    /// Green chroma, `G - (R + B) / 2`.
    pub cg: f32,
}

/// Converts RGB to YCoCg-R.
pub fn ycocg_from_rgb([r, g, b]: [f32; 3]) -> YCoCg {
    let co = r - b;
    let t = b + co / 2.0;
    let cg = g - t;
    let y = t + cg / 2.0;
    YCoCg { y, co, cg }
}

/// Converts YCoCg-R to RGB without clamping. The signs are those of the thesis's section 3.5.5.
pub fn rgb_from_ycocg(YCoCg { y, co, cg }: YCoCg) -> [f32; 3] {
    let t = y - cg / 2.0;
    let g = cg + t;
    let b = t - co / 2.0;
    let r = b + co;
    [r, g, b]
}

/// Decodes an sRGB value in `[0, 1]` to linear light in `[0, 1]` (IEC 61966-2-1).
pub fn linear_from_srgb(encoded: f32) -> f32 {
    if encoded <= 0.04045 {
        encoded / 12.92
    } else {
        ((encoded + 0.055) / 1.055).powf(2.4)
    }
}

/// Encodes linear light in `[0, 1]` as an sRGB value in `[0, 1]`.
pub fn srgb_from_linear(linear: f32) -> f32 {
    if linear <= 0.003_130_8 {
        linear * 12.92
    } else {
        1.055 * linear.powf(1.0 / 2.4) - 0.055
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The integer form of Malvar and Sullivan, with shifts that round down: an independent check.
    fn ycocg_r_integer([r, g, b]: [i32; 3]) -> [i32; 3] {
        let co = r - b;
        let t = b + (co >> 1);
        let cg = g - t;
        [t + (cg >> 1), co, cg]
    }

    #[test]
    fn round_trip_is_exact_for_all_corners_and_a_grid() {
        for r in (0..=255).step_by(15) {
            for g in (0..=255).step_by(15) {
                for b in (0..=255).step_by(15) {
                    let rgb = [r, g, b].map(|v| v as f32 / 255.0);
                    let back = rgb_from_ycocg(ycocg_from_rgb(rgb));
                    for (a, b) in rgb.iter().zip(back) {
                        assert!((a - b).abs() < 1e-6);
                    }
                }
            }
        }
    }

    #[test]
    fn agrees_with_the_integer_transform_within_its_rounding() {
        for rgb in [
            [255, 0, 0],
            [0, 255, 0],
            [0, 0, 255],
            [13, 200, 77],
            [1, 2, 4],
        ] {
            let exact = ycocg_from_rgb(rgb.map(|v| v as f32));
            let [y, co, cg] = ycocg_r_integer(rgb);
            assert_eq!(exact.co, co as f32);
            assert!((exact.cg - cg as f32).abs() <= 0.5);
            assert!((exact.y - y as f32).abs() <= 0.75);
        }
    }

    #[test]
    fn srgb_curve_inverts_and_is_continuous_at_its_knee() {
        for i in 0..=1000 {
            let v = i as f32 / 1000.0;
            assert!((srgb_from_linear(linear_from_srgb(v)) - v).abs() < 1e-5);
        }
        assert!((linear_from_srgb(0.04045) - linear_from_srgb(0.040_451)).abs() < 1e-6);
    }
}

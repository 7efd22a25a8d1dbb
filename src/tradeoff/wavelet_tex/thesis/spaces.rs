//! The colour spaces that the thesis compares, with 8 bits a channel (section 3.3.1).

/// A transform of R, G and B in `0..=255` to luma and two chromas, and back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Space {
    /// YCoCg-R by lifting steps, with one bit more in its chromas; lossless.
    YCoCgR,
    /// YCoCg, rounded to 8 bits.
    YCoCg,
    /// YCbCr, rounded to 8 bits.
    YCbCr,
}

impl Space {
    pub fn name(self) -> &'static str {
        match self {
            Self::YCoCgR => "YCoCg-R",
            Self::YCoCg => "YCoCg",
            Self::YCbCr => "YCbCr",
        }
    }

    /// Transforms to luma in `0..=255` and chromas in `-255..=255` (YCoCg-R) or `-128..=128`.
    pub fn forward(self, rgb: [u8; 3]) -> [i32; 3] {
        let [r, g, b] = rgb.map(i32::from);
        match self {
            Self::YCoCgR => {
                let co = r - b;
                let t = b + (co >> 1);
                let cg = g - t;
                [t + (cg >> 1), co, cg]
            }
            Self::YCoCg => {
                // This is Eq. 3.3 in quarters.
                let rounded = |quarters: i32| (quarters + 2) >> 2;
                [r + 2 * g + b, 2 * (r - b), 2 * g - r - b].map(rounded)
            }
            Self::YCbCr => {
                // This is Eq. 3.1, whose second row is Cr and third Cb.
                let [r, g, b] = [r, g, b].map(|v| v as f32);
                let rows = [
                    0.299 * r + 0.587 * g + 0.114 * b,
                    0.5 * r - 0.4187 * g - 0.0813 * b,
                    -0.1687 * r - 0.3313 * g + 0.5 * b,
                ];
                rows.map(|v| v.round() as i32)
            }
        }
    }

    /// Transforms to R, G and B without clamping.
    pub fn inverse(self, planes: [f32; 3]) -> [f32; 3] {
        let [y, first, second] = planes;
        match self {
            Self::YCoCgR => {
                let [y, co, cg] = planes.map(|v| v.round() as i32);
                let t = y - (cg >> 1);
                let b = t - (co >> 1);
                [b + co, cg + t, b].map(|v| v as f32)
            }
            Self::YCoCg => [y + first - second, y + second, y - first - second],
            Self::YCbCr => [
                y + 1.402 * first,
                y - 0.714 * first - 0.344 * second,
                y + 1.772 * second,
            ],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const ALL: [Space; 3] = [Space::YCoCgR, Space::YCoCg, Space::YCbCr];

    proptest! {
        #[test]
        fn only_ycocg_r_loses_nothing(rgb in prop::array::uniform3(0u8..=255)) {
            for space in ALL {
                let planes = space.forward(rgb).map(|v| v as f32);
                let back = space.inverse(planes).map(f32::round);
                let most = match space {
                    Space::YCoCgR => 0.0,
                    // The bound is half a step in each of up to three terms, and the rounding of
                    // Eq. 3.2 itself.
                    Space::YCoCg | Space::YCbCr => 2.0,
                };
                for (a, b) in back.iter().zip(rgb) {
                    prop_assert!((a - f32::from(b)).abs() <= most, "{space:?} {rgb:?} {back:?}");
                }
            }
        }
    }

    #[test]
    fn gray_has_no_chroma() {
        for space in ALL {
            assert_eq!(space.forward([77; 3]), [77, 0, 0]);
        }
    }
}

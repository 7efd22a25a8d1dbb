//! Lossless integer wavelet transforms (thesis section 3.6.1).
//!
//! Both transform two values to a scale coefficient and a detail. Of 2 x 2 values they transform
//! first the rows, then the columns.

/// A function that transforms two values to a scale coefficient and a detail, or back.
pub type Step = fn(i32, i32) -> (i32, i32);

/// The S-transform: the mean, rounded down, and the difference. For values of 8 bits the details
/// need 9 bits, and the details of details 10.
pub fn s_transform(a: i32, b: i32) -> (i32, i32) {
    ((a + b) >> 1, a - b)
}

/// The inverse of [`s_transform`].
pub fn inverse_s_transform(mean: i32, difference: i32) -> (i32, i32) {
    let a = mean + ((difference + 1) >> 1);
    (a, a - difference)
}

/// PLHaar (J. G. Senecal, P. Lindstrom, M. A. Duchaineau, K. I. Joy, *An Improved N-Bit to N-Bit
/// Reversible Haar-Like Transform*, Pacific Graphics 2004): the Haar transform's rotation by 45
/// degrees, along squares instead of circles, so that values in `-128..=127` stay in that range.
///
/// Each side of a square spans 90 degrees. Where the signs of both values agree, the larger one (by
/// magnitude) is the scale coefficient and their difference the detail; where they differ, the
/// larger one is the detail and their sum the scale coefficient. Negative values count from -1 as
/// the others do from 0, so that all four quadrants have the same size.
pub fn pl_haar(a: i32, b: i32) -> (i32, i32) {
    let (s, t) = (i32::from(a < 0), i32::from(b < 0));
    let (a, b) = (a + s, b + t);
    let first_is_larger = a.abs() >= b.abs();
    let (scale, detail) = if s == t {
        (if first_is_larger { a } else { b }, a - b)
    } else {
        (a + b, if first_is_larger { a } else { -b })
    };
    (scale - t, detail - s)
}

/// The inverse of [`pl_haar`].
pub fn inverse_pl_haar(scale: i32, detail: i32) -> (i32, i32) {
    let magnitude = |v: i32| if v < 0 { -1 - v } else { v };
    let [scale_sign, detail_sign] = [scale, detail].map(|v| i32::from(v < 0));
    let signs_agree = match magnitude(scale).cmp(&magnitude(detail)) {
        std::cmp::Ordering::Greater => true,
        std::cmp::Ordering::Equal => scale_sign == detail_sign,
        std::cmp::Ordering::Less => false,
    };
    // The sign of the larger coefficient determines both signs.
    let (s, t) = if signs_agree {
        (scale_sign, scale_sign)
    } else {
        (detail_sign, 1 - detail_sign)
    };
    let (scale, detail) = (scale + t, detail + s);
    let first_is_larger = scale.signum() * detail.signum() >= 0;
    let (a, b) = match (signs_agree, first_is_larger) {
        (true, true) => (scale, scale - detail),
        (true, false) => (scale + detail, scale),
        (false, true) => (detail, scale - detail),
        (false, false) => (scale + detail, -detail),
    };
    (a - s, b - t)
}

/// Transforms `[a, b, c, d]` (a b above c d) to LL, HL, LH and HH.
pub fn forward(step: Step, [a, b, c, d]: [i32; 4]) -> [i32; 4] {
    let (upper, upper_detail) = step(a, b);
    let (lower, lower_detail) = step(c, d);
    let (ll, lh) = step(upper, lower);
    let (hl, hh) = step(upper_detail, lower_detail);
    [ll, hl, lh, hh]
}

/// Transforms LL, HL, LH and HH to `[a, b, c, d]` by the inverse step.
pub fn inverse(step: Step, [ll, hl, lh, hh]: [i32; 4]) -> [i32; 4] {
    let (upper, lower) = step(ll, lh);
    let (upper_detail, lower_detail) = step(hl, hh);
    let (a, b) = step(upper, upper_detail);
    let (c, d) = step(lower, lower_detail);
    [a, b, c, d]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn pl_haar_takes_every_pair_of_bytes_to_another_and_back() {
        let mut found = vec![false; 1 << 16];
        for a in -128..128 {
            for b in -128..128 {
                let (scale, detail) = pl_haar(a, b);
                assert!((-128..128).contains(&scale) && (-128..128).contains(&detail));
                assert_eq!(inverse_pl_haar(scale, detail), (a, b));
                let index = ((scale + 128) << 8 | (detail + 128)) as usize;
                assert!(!std::mem::replace(&mut found[index], true));
            }
        }
        assert!(found.iter().all(|found| *found));
    }

    #[test]
    fn pl_haar_turns_squares_by_an_eighth() {
        assert_eq!(pl_haar(100, 100), (100, 0)); // a corner to the middle of a side
        assert_eq!(pl_haar(100, 0), (100, 100)); // and the middle of a side to a corner
        assert_eq!(pl_haar(0, 100), (100, -100));
        assert_eq!(pl_haar(0, 0), (0, 0));
    }

    #[test]
    fn the_s_transform_has_means_and_differences() {
        assert_eq!(s_transform(7, 4), (5, 3));
        assert_eq!(s_transform(-1, -2), (-2, 1));
    }

    proptest! {
        #[test]
        fn both_lose_nothing(bytes in prop::array::uniform4(-128i32..128)) {
            let s = forward(s_transform, bytes);
            prop_assert_eq!(inverse(inverse_s_transform, s), bytes);
            prop_assert!((-128..128).contains(&s[0]));
            prop_assert!(s[1..3].iter().all(|d| d.abs() <= 255) && s[3].abs() <= 510);
            let pl = forward(pl_haar, bytes);
            prop_assert_eq!(inverse(inverse_pl_haar, pl), bytes);
            prop_assert!(pl.iter().all(|c| (-128..128).contains(c)));
        }
    }
}

//! The steps in which transmissive objects are drawn.

use std::ops::Range;

/// Splits `len` transmissive objects, sorted from back to front, into `steps` ranges, each of which
/// samples the result of the ranges before it; 0 steps give one range.
pub(super) fn transmission_ranges(len: usize, steps: usize) -> Vec<Range<usize>> {
    let count = steps.clamp(1, len.max(1));
    (0..count)
        .map(|i| len * i / count..len * (i + 1) / count)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::transmission_ranges;

    #[test]
    fn ranges_cover_all_and_differ_by_one_at_most() {
        for len in 1..20 {
            for steps in 0..25 {
                let ranges = transmission_ranges(len, steps);
                assert_eq!(ranges.len(), steps.clamp(1, len));
                assert_eq!(ranges[0].start, 0);
                assert_eq!(ranges[ranges.len() - 1].end, len);
                assert!(ranges.windows(2).all(|w| w[0].end == w[1].start));
                assert!(
                    ranges
                        .iter()
                        .all(|r| r.len().abs_diff(len / ranges.len()) <= 1)
                );
            }
        }
    }
}

//! The threshold of an ordered dither.

/// Returns the threshold of a pixel, in units of 2^-32: the additive sequence of the plastic number, whose values
/// in any neighbourhood are spread evenly (M. Roberts, *The Unreasonable Effectiveness of Quasirandom Sequences*,
/// 2018).
pub fn threshold(x: u32, y: u32) -> u32 {
    x.wrapping_mul(0xc13f_a9a9)
        .wrapping_add(y.wrapping_mul(0x91e1_0da5))
}

#[cfg(test)]
mod tests {
    use super::*;

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

//! Ordered dithering.

/// An 8 x 8 threshold matrix (B. E. Bayer, 1973) at a pixel: -0.5 to 0.5, with a mean of 0.
pub(super) fn threshold(x: u32, y: u32) -> f32 {
    // Bits of x ^ y and y, the lowest first, interleaved to the highest.
    let rank = (0..3).fold(0, |rank, bit| {
        let (a, b) = ((x ^ y) >> bit & 1, y >> bit & 1);
        rank << 2 | a << 1 | b
    });
    (rank as f32 + 0.5) / 64.0 - 0.5
}

/// The value of 0 to 1 that a dithered channel of so many levels above 0 stores.
pub(super) fn quantized(value: f32, levels: f32, threshold: f32) -> f32 {
    (value * levels + threshold).round().clamp(0.0, levels) / levels
}

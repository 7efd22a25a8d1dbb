//! The error of details that are stored together (thesis Table 3.1).

use bevy_wavelet_tex::codec::{
    blocks::{BlockFormat, BlockQuality, Texel, decode_blocks, encode_bc1},
    haar::{Transform, haar},
};

/// The cases of the thesis: the name, the transform, and whether the other two channels store their details,
/// too.
pub const CASES: [(&str, Transform, bool); 4] = [
    ("Haar: HL, 0, 0", Transform::Haar, false),
    ("Haar: HL, LH, HH", Transform::Haar, true),
    ("PI-Haar: HL', 0, 0", PI_HAAR, false),
    ("PI-Haar: HL', LH', HH'", PI_HAAR, true),
];

const PI_HAAR: Transform = Transform::PartiallyInvertedHaar { w: 0.4 };

/// Mean squared error of R, the first detail, in 8-bit units. `quads` are the 2 x 2 values of a plane,
/// `size` of them, in `0..=255`.
pub fn error_of_first(
    transform: Transform,
    together: bool,
    quads: &[[f32; 4]],
    size: [u32; 2],
) -> f64 {
    let texel = |quad: &[f32; 4]| -> Texel {
        // The detail is in -255 to 255 and is stored in 8 bits.
        let byte = |detail: f32| (128.0 + detail / 2.0).round().clamp(0.0, 255.0) as u8;
        let [r, g, b] = transform.mix(haar(*quad).details).map(byte);
        if together {
            [r, g, b, 255]
        } else {
            [r, 128, 128, 255]
        }
    };
    let texels: Vec<Texel> = quads.iter().map(texel).collect();
    let blocks = encode_bc1(&texels, size, BlockQuality::High);
    let decoded = decode_blocks(BlockFormat::Bc1, &blocks, size);
    let pairs = texels.iter().zip(decoded);
    let sum: f64 = pairs
        .map(|(wanted, got)| f64::from(f32::from(wanted[0]) - 255.0 * got[0]).powi(2))
        .sum();
    sum / texels.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn details_that_go_together_lose_less() {
        // The values vary in one pixel of each quad, so HL and LH rise and fall together.
        let alike: Vec<_> = (0..256)
            .map(|i| [(i * 37 % 101) as f32, 50.0, 50.0, 50.0])
            .collect();
        let apart: Vec<_> = (0..256i32)
            .map(|i| [i * 37 % 101, i * 53 % 97, i * 71 % 89, i * 29 % 83].map(|v| v as f32))
            .collect();
        let error = |quads: &[[f32; 4]]| error_of_first(Transform::Haar, true, quads, [16, 16]);
        assert!(4.0 * error(&alike) < error(&apart));
        let alone = error_of_first(Transform::Haar, false, &apart, [16, 16]);
        assert!(2.0 * alone < error(&apart));
    }
}

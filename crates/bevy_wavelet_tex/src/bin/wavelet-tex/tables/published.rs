//! Published figures of the thesis and of other formats.

/// The thesis's Table 3.1, of Lena: mean squared errors in the order of `correlation::CASES`.
pub const CORRELATION: [f64; 4] = [4.6, 31.1, 4.3, 11.0];

/// The thesis's Table 3.3, of Lena: PSNR in dB in the order of `WAVELETS`.
pub const WAVELETS: [f64; 4] = [33.29, 32.04, 33.04, 33.86];

/// The thesis's Table 3.3, of Lena: PSNR in dB in the order of `Space::ALL`.
pub const SPACES: [f64; 3] = [33.86, 33.76, 33.42];

/// The thesis's Table 3.4: mean PSNR in dB of the Kodak images at the rates that it has.
pub fn thesis(rate: &str) -> Option<f64> {
    match rate {
        "gray2" => Some(34.0),
        "color2.25" => Some(32.6),
        "color3" => Some(33.4),
        "color5" => Some(39.3),
        _ => None,
    }
}

/// Other formats on the Kodak images in colour: name, bits per pixel, PSNR in dB, source. Desktop
/// GPUs support none of them.
pub const OTHERS: [(&str, f64, f64, &str); 8] = [
    ("ASTC 12x12", 0.89, 30.79, "astcenc 5"),
    ("ASTC 8x8", 2.0, 34.64, "astcenc 5"),
    ("ASTC 6x6", 3.56, 38.45, "astcenc 5"),
    ("ASTC 4x4", 8.0, 45.50, "astcenc 5"),
    ("ASTC 8x8", 2.0, 33.9, "thesis, Table 3.5"),
    ("ASTC 6x6", 3.56, 38.0, "thesis, Table 3.5"),
    ("PVRTC", 2.0, 31.7, "thesis, Table 3.5"),
    ("PVRTC", 4.0, 36.1, "thesis, Table 3.5"),
];

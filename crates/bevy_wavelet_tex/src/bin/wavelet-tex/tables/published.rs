//! Figures that others have published, in dB.

/// The thesis's Table 3.1, of Lena: mean squared errors in the order of `correlation::CASES`.
pub const CORRELATION: [f64; 4] = [4.6, 31.1, 4.3, 11.0];

/// Its Table 3.3, of Lena: in the order of `WAVELETS`.
pub const WAVELETS: [f64; 4] = [33.29, 32.04, 33.04, 33.86];

/// The same: in the order of `Space::ALL`.
pub const SPACES: [f64; 3] = [33.86, 33.76, 33.42];

/// Its Table 3.4: the means of the Kodak images at our rates.
pub fn thesis(rate: &str) -> Option<f64> {
    match rate {
        "gray2" => Some(34.0),
        "color2.25" => Some(32.6),
        "color3" => Some(33.4),
        "color5" => Some(39.3),
        _ => None,
    }
}

/// Of the Kodak images in colour: what, bits per pixel, PSNR, source. Desktop GPUs have none of these.
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

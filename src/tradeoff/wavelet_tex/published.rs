//! Published figures of the thesis and of other formats.

/// The references of the rows that rebuild these tables.
pub(super) const TABLE_3_1: &str = "thesis table 3.1";
pub(super) const TABLE_3_3: &str = "thesis table 3.3";

/// The thesis's Table 3.1, of Lena: mean squared errors.
pub(super) const CORRELATION: [(&str, f64); 4] = [
    ("Haar: HL, 0, 0", 4.6),
    ("Haar: HL, LH, HH", 31.1),
    ("PI-Haar: HL', 0, 0", 4.3),
    ("PI-Haar: HL', LH', HH'", 11.0),
];

/// The thesis's Table 3.3, of Lena: PSNR in dB of the wavelets.
pub(super) const WAVELETS: [(&str, f64); 4] = [
    ("Haar", 33.29),
    ("PLHaar", 32.04),
    ("S-transform", 33.04),
    ("PI-Haar", 33.86),
];

/// The thesis's Table 3.3, of Lena: PSNR in dB of the colour spaces with PI-Haar.
pub(super) const SPACES: [(&str, f64); 3] =
    [("YCoCg-R", 33.86), ("YCoCg", 33.76), ("YCbCr", 33.42)];

/// The thesis's Table 3.4: rates, their bits per pixel, and the mean PSNR in dB of the Kodak images.
pub(super) const RATES: [(&str, f64, f64); 4] = [
    ("gray2", 2.0, 34.0),
    ("color2.25", 2.25, 32.6),
    ("color3", 3.0, 33.4),
    ("color5", 5.0, 39.3),
];

/// Other formats on the Kodak images in colour: name, bits per pixel, PSNR in dB, source. Desktop
/// GPUs support none of them.
pub(super) const OTHERS: [(&str, f64, f64, &str); 8] = [
    ("ASTC 12x12", 0.89, 30.79, "astcenc 5"),
    ("ASTC 8x8", 2.0, 34.64, "astcenc 5"),
    ("ASTC 6x6", 3.56, 38.45, "astcenc 5"),
    ("ASTC 4x4", 8.0, 45.50, "astcenc 5"),
    ("ASTC 8x8", 2.0, 33.9, "thesis, Table 3.5"),
    ("ASTC 6x6", 3.56, 38.0, "thesis, Table 3.5"),
    ("PVRTC", 2.0, 31.7, "thesis, Table 3.5"),
    ("PVRTC", 4.0, 36.1, "thesis, Table 3.5"),
];

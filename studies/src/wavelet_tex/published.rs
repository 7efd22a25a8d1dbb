//! Published figures of the thesis.

/// The thesis's Table 3.4: rates, their bits per pixel, and the mean PSNR in dB of the Kodak images.
pub(super) const RATES: [(&str, f64, f64); 4] = [
    ("gray2", 2.0, 34.0),
    ("color2.25", 2.25, 32.6),
    ("color3", 3.0, 33.4),
    ("color5", 5.0, 39.3),
];

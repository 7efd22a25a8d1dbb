//! The filters of the plugin, and those of the hardware.

use bevy::render::render_resource::TextureFormat;
use bevy_wavelet_tex::WaveletFilter;

/// A filter of the plugin, and the hardware's that is most similar.
#[derive(Clone, Copy, Debug)]
pub struct Filter {
    pub filter: WaveletFilter,
    pub name: &'static str,
    /// Neighbouring pixels that it decodes together.
    pub pixels: f64,
    /// How often it does that.
    pub lookups: f64,
    pub hardware: &'static str,
}

/// All filters. An anisotropic sample of the plugin is counted as one trilinear one; it is up to 16 of them
/// where a footprint is long and narrow.
pub const FILTERS: [Filter; 7] = [
    Filter::new(WaveletFilter::Nearest, "nearest", [1.0, 1.0], "nearest"),
    Filter::new(
        WaveletFilter::NearestMipLinear,
        "nearest mip linear",
        [1.0, 2.0],
        "nearest mip linear",
    ),
    Filter::new(
        WaveletFilter::Stochastic,
        "stochastic",
        [1.0, 1.0],
        "anisotropic",
    ),
    Filter::new(
        WaveletFilter::StochasticQuad,
        "stochastic quad",
        [1.0, 1.0],
        "anisotropic",
    ),
    Filter::new(WaveletFilter::Bilinear, "bilinear", [4.0, 1.0], "bilinear"),
    Filter::new(
        WaveletFilter::Trilinear,
        "trilinear",
        [4.0, 2.0],
        "trilinear",
    ),
    Filter::new(
        WaveletFilter::Anisotropic,
        "anisotropic",
        [4.0, 2.0],
        "anisotropic",
    ),
];

impl Filter {
    const fn new(
        filter: WaveletFilter,
        name: &'static str,
        [pixels, lookups]: [f64; 2],
        hardware: &'static str,
    ) -> Self {
        Self {
            filter,
            name,
            pixels,
            lookups,
            hardware,
        }
    }
}

/// The hardware's filters with the texels that they blend.
pub(super) const HARDWARE: [(&str, f64); 5] = [
    ("nearest", 1.0),
    ("nearest mip linear", 2.0),
    ("bilinear", 4.0),
    ("trilinear", 8.0),
    ("anisotropic", 128.0),
];

/// Formats of the hardware's rows: name, bytes of a texel, format.
pub(super) const FORMATS: [(&str, f64, TextureFormat); 3] = [
    ("rgba8", 4.0, TextureFormat::Rgba8UnormSrgb),
    ("bc7", 1.0, TextureFormat::Bc7RgbaUnormSrgb),
    ("bc1", 0.5, TextureFormat::Bc1RgbaUnormSrgb),
];

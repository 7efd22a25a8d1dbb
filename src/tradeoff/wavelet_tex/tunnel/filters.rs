//! The filters of the plugin, and those of the hardware.

use bevy::render::render_resource::TextureFormat;
use bevy_wavelet_tex::WaveletFilter;

/// A filter of the plugin, and the hardware's that is most similar.
#[derive(Clone, Copy, Debug)]
pub struct Filter {
    pub filter: WaveletFilter,
    pub name: &'static str,
    /// Decoded pixels that it blends.
    pub pixels: f64,
    pub hardware: &'static str,
}

/// All filters. An anisotropic sample of the plugin is a bilinear one (up to 16 where a footprint is long
/// and narrow) and one of the texture unit, which is not counted.
pub const FILTERS: [Filter; 6] = [
    Filter::new(WaveletFilter::Nearest, "nearest", 1.0, "nearest"),
    Filter::new(
        WaveletFilter::NearestMipLinear,
        "nearest mip linear",
        2.0,
        "nearest mip linear",
    ),
    Filter::new(WaveletFilter::Bilinear, "bilinear", 4.0, "bilinear"),
    Filter::new(
        WaveletFilter::OneFetchTrilinear,
        "one fetch trilinear",
        4.0,
        "trilinear",
    ),
    Filter::new(WaveletFilter::Trilinear, "trilinear", 8.0, "trilinear"),
    Filter::new(
        WaveletFilter::Anisotropic,
        "anisotropic",
        4.0,
        "anisotropic",
    ),
];

impl Filter {
    const fn new(
        filter: WaveletFilter,
        name: &'static str,
        pixels: f64,
        hardware: &'static str,
    ) -> Self {
        Self {
            filter,
            name,
            pixels,
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

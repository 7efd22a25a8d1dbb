//! The cameras whose cost is measured, by name.

use bevy::{render::render_resource::TextureFormat, utils::default};
use bevy_ycocg_fb::{FrameBufferQuality, PackedFormat, Reconstruction, YCoCgFrameBuffer};

use super::settings::REFERENCE;

/// A camera by what its colours are drawn to.
#[derive(Clone, Copy, Debug)]
pub struct Camera {
    /// Its name in the records.
    pub name: &'static str,
    /// Bytes of a sample of colour.
    pub bytes: u32,
    pub hdr: bool,
    /// A target of this format in place of the picture.
    pub target: Option<TextureFormat>,
    pub quality: FrameBufferQuality,
}

impl Camera {
    fn packed(name: &'static str, bytes: u32, hdr: bool, packed: YCoCgFrameBuffer) -> Self {
        Self::with_quality(name, bytes, hdr, packed.into())
    }

    fn with_quality(
        name: &'static str,
        bytes: u32,
        hdr: bool,
        quality: FrameBufferQuality,
    ) -> Self {
        Self {
            name,
            bytes,
            hdr,
            target: None,
            quality,
        }
    }

    fn target(name: &'static str, bytes: u32, target: TextureFormat) -> Self {
        Self {
            name,
            bytes,
            hdr: false,
            target: Some(target),
            quality: FrameBufferQuality::Exact,
        }
    }
}

/// Bevy's own, what a user would pick today, and the plugin's: resolved to Bevy's HDR texture, or tone-mapped.
pub fn cameras() -> Vec<Camera> {
    vec![
        Camera::with_quality(REFERENCE, 8, true, FrameBufferQuality::Exact),
        Camera::with_quality("rg11b10ufloat", 4, true, FrameBufferQuality::Compact),
        Camera::packed("packed_hdr", 4, true, default()),
        Camera::packed("packed_fused", 4, false, default()),
    ]
}

/// The other filters: their time is in the resolve alone, so they are measured without layers.
pub fn filters() -> impl Iterator<Item = Camera> {
    let filters = [
        ("packed_hdr nearest", Reconstruction::Nearest),
        ("packed_hdr bilinear", Reconstruction::Bilinear),
        ("packed_hdr edge_directed", Reconstruction::EdgeDirected),
        ("packed_hdr guided", Reconstruction::Guided),
        ("packed_hdr quad", Reconstruction::Quad),
    ];
    filters.into_iter().map(|(name, reconstruction)| {
        let packed = YCoCgFrameBuffer {
            reconstruction,
            ..default()
        };
        Camera::packed(name, 4, true, packed)
    })
}

/// Those, and the cameras with 8 and 32 bits a channel.
pub fn all_cameras() -> Vec<Camera> {
    let mut all = cameras();
    all.extend([
        Camera::target("rgba8", 4, TextureFormat::Rgba8UnormSrgb),
        Camera::packed(
            "packed_unorm8",
            2,
            false,
            YCoCgFrameBuffer::with_format(PackedFormat::Unorm8),
        ),
        Camera::target("rgba32float", 16, TextureFormat::Rgba32Float),
        Camera::packed(
            "packed_float32",
            8,
            true,
            YCoCgFrameBuffer::with_format(PackedFormat::Float32),
        ),
    ]);
    all
}

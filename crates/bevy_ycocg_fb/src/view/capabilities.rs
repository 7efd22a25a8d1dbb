//! The adapter's support of the formats.

use bevy::render::{
    render_resource::{
        TextureFormatFeatureFlags, TextureFormatFeatures, TextureUsages, WgpuFeatures,
    },
    renderer::{RenderAdapter, RenderDevice},
};

use crate::fallback::FallbackReason;
use crate::settings::FrameBufferFormat;

/// The adapter's support of multisampled textures of a format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct FormatSupport {
    /// Whether the hardware can resolve samples of this format.
    pub hardware_resolve: bool,
}

impl FormatSupport {
    /// Queries the adapter.
    ///
    /// # Errors
    /// Returns the feature that the adapter lacks as the reason of the fallback.
    pub(crate) fn of(
        format: FrameBufferFormat,
        samples: u32,
        adapter: &RenderAdapter,
        device: &RenderDevice,
    ) -> Result<Self, FallbackReason> {
        let texture_format = format.texture_format();
        let specific = WgpuFeatures::TEXTURE_ADAPTER_SPECIFIC_FORMAT_FEATURES;
        let features = if device.features().contains(specific) {
            adapter.get_texture_format_features(texture_format)
        } else {
            texture_format.guaranteed_format_features(device.features())
        };
        Self::from_features(format, samples, features)
    }

    fn from_features(
        format: FrameBufferFormat,
        samples: u32,
        features: TextureFormatFeatures,
    ) -> Result<Self, FallbackReason> {
        let flags = features.flags;
        if !features
            .allowed_usages
            .contains(TextureUsages::RENDER_ATTACHMENT)
        {
            return Err(FallbackReason::NotRenderable(format));
        }
        if !flags.contains(TextureFormatFeatureFlags::BLENDABLE) {
            return Err(FallbackReason::NotBlendable(format));
        }
        if samples > 1 && !flags.sample_count_supported(samples) {
            return Err(FallbackReason::SampleCount { format, samples });
        }
        Ok(Self {
            hardware_resolve: flags.contains(TextureFormatFeatureFlags::MULTISAMPLE_RESOLVE),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::PackedFormat;

    /// Returns the support of an adapter with only the features that WebGPU guarantees, and these.
    fn with_features(
        format: FrameBufferFormat,
        samples: u32,
        features: WgpuFeatures,
    ) -> Result<FormatSupport, FallbackReason> {
        let features = format.texture_format().guaranteed_format_features(features);
        FormatSupport::from_features(format, samples, features)
    }

    fn guaranteed(
        format: FrameBufferFormat,
        samples: u32,
    ) -> Result<FormatSupport, FallbackReason> {
        with_features(format, samples, WgpuFeatures::empty())
    }

    #[test]
    fn what_every_adapter_can_do() {
        let resolved = FormatSupport {
            hardware_resolve: true,
        };
        for format in [PackedFormat::Float16, PackedFormat::Unorm8].map(FrameBufferFormat::from) {
            assert_eq!(guaranteed(format, 1), Ok(resolved));
            assert_eq!(guaranteed(format, 4), Ok(resolved));
            for samples in [2, 8] {
                let missing = FallbackReason::SampleCount { format, samples };
                assert_eq!(guaranteed(format, samples), Err(missing));
            }
        }
        let float32 = PackedFormat::Float32.into();
        assert_eq!(
            guaranteed(float32, 1),
            Err(FallbackReason::NotBlendable(float32))
        );
        let small_floats = FrameBufferFormat::Rg11b10Ufloat;
        assert_eq!(
            guaranteed(small_floats, 1),
            Err(FallbackReason::NotRenderable(small_floats))
        );
        let renderable = WgpuFeatures::RG11B10UFLOAT_RENDERABLE;
        assert_eq!(with_features(small_floats, 4, renderable), Ok(resolved));
    }
}

//! Which images get mip levels, and why others do not.

use bevy::{
    prelude::*,
    render::{
        render_resource::{
            TextureDescriptor, TextureDimension, TextureFormat, TextureSampleType, TextureUsages,
            WgpuFeatures,
        },
        renderer::{RenderAdapter, RenderDevice},
    },
};

/// Why a texture has no generated mip levels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Reflect)]
#[reflect(Debug, PartialEq, Hash)]
#[non_exhaustive]
pub enum NoMips {
    /// The image is not loaded yet, or was removed.
    NotLoaded,
    /// The app excluded the image, or limited its levels to one.
    Excluded,
    /// The image has a single texel.
    OneTexel,
    /// The sampler chooses the nearest texel, as for pixel art. [`EwaImage::use_nearest`] changes this.
    ///
    /// [`EwaImage::use_nearest`]: crate::EwaImage::use_nearest
    NearestSampler,
    /// Cameras draw to the image or shaders write it, and the app did not ask for levels after each draw.
    /// [`EwaImage::after_draws`] does so.
    ///
    /// [`EwaImage::after_draws`]: crate::EwaImage::after_draws
    WrittenOnGpu,
    /// The image has one or three dimensions, or several samples a texel.
    Dimension,
    /// The device cannot draw to the format: compressed formats, signed normalized formats and RGB9E5, on some devices
    /// 16-bit normalized formats. Such images need levels of their own, which tools of these formats write.
    Format(#[reflect(ignore, default = "unknown_format")] TextureFormat),
    /// Nothing renders.
    NoRenderer,
}

fn unknown_format() -> TextureFormat {
    TextureFormat::Rgba8Unorm
}

/// What the device can generate levels of.
pub(crate) struct MipSupport<'a> {
    device: &'a RenderDevice,
    adapter: &'a RenderAdapter,
}

impl<'a> MipSupport<'a> {
    pub(crate) fn new(device: &'a RenderDevice, adapter: &'a RenderAdapter) -> Self {
        Self { device, adapter }
    }

    fn can_draw_to(&self, format: TextureFormat) -> bool {
        let features = self.device.features();
        let adapters_own = WgpuFeatures::TEXTURE_ADAPTER_SPECIFIC_FORMAT_FEATURES;
        let format_features = if features.contains(adapters_own) {
            self.adapter.get_texture_format_features(format)
        } else {
            format.guaranteed_format_features(features)
        };
        let usages = TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING;
        let is_float = matches!(
            format.sample_type(None, Some(features)),
            Some(TextureSampleType::Float { .. })
        );
        is_float && format_features.allowed_usages.contains(usages)
    }

    /// The number of levels that a texture without levels of its own could have.
    pub(crate) fn levels(&self, descriptor: &TextureDescriptor) -> Result<u32, NoMips> {
        if descriptor.dimension != TextureDimension::D2 || descriptor.sample_count != 1 {
            return Err(NoMips::Dimension);
        }
        if !self.can_draw_to(descriptor.format) {
            return Err(NoMips::Format(descriptor.format));
        }
        match descriptor.size.max_mips(descriptor.dimension) {
            1 => Err(NoMips::OneTexel),
            levels => Ok(levels),
        }
    }
}

/// Whether cameras draw to a texture, or shaders write it.
pub(crate) fn is_written_on_gpu(descriptor: &TextureDescriptor) -> bool {
    let written = TextureUsages::RENDER_ATTACHMENT | TextureUsages::STORAGE_BINDING;
    descriptor.usage.intersects(written)
}

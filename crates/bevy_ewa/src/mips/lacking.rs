//! Images without mip levels that can have them.

use bevy::{
    prelude::*,
    render::render_resource::{TextureDimension, TextureFormat},
};

use super::texel::{Storage, TexelFormat};

/// Whether a mip chain can be generated for an image and is missing.
pub(crate) fn lacks_mips(image: &Image) -> bool {
    let descriptor = &image.texture_descriptor;
    descriptor.mip_level_count == 1
        && descriptor.dimension == TextureDimension::D2
        && descriptor.size.depth_or_array_layers == 1
        && (descriptor.size.width > 1 || descriptor.size.height > 1)
        && image.data.is_some()
        && texel_format(descriptor.format).is_some()
}

/// The texels of a format, if a mip chain can be generated from them.
pub(super) fn texel_format(format: TextureFormat) -> Option<TexelFormat> {
    let (channels, storage, srgb) = match format {
        TextureFormat::R8Unorm => (1, Storage::Unorm8, false),
        TextureFormat::Rg8Unorm => (2, Storage::Unorm8, false),
        TextureFormat::Rgba8Unorm | TextureFormat::Bgra8Unorm => (4, Storage::Unorm8, false),
        TextureFormat::Rgba8UnormSrgb | TextureFormat::Bgra8UnormSrgb => (4, Storage::Unorm8, true),
        TextureFormat::R16Unorm => (1, Storage::Unorm16, false),
        TextureFormat::Rg16Unorm => (2, Storage::Unorm16, false),
        TextureFormat::Rgba16Unorm => (4, Storage::Unorm16, false),
        TextureFormat::R16Float => (1, Storage::Float16, false),
        TextureFormat::Rg16Float => (2, Storage::Float16, false),
        TextureFormat::Rgba16Float => (4, Storage::Float16, false),
        TextureFormat::R32Float => (1, Storage::Float32, false),
        TextureFormat::Rg32Float => (2, Storage::Float32, false),
        TextureFormat::Rgba32Float => (4, Storage::Float32, false),
        _ => return None,
    };
    Some(TexelFormat {
        channels,
        storage,
        srgb,
    })
}

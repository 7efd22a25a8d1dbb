//! The texture that Bevy samples.

use bevy::{
    asset::RenderAssetUsages,
    image::{ImageAddressMode, ImageSampler, ImageSamplerDescriptor},
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat, TextureUsages},
};

use crate::settings::VoxelGiVolume;

/// Texels of the texture: per cascade six ambient-cube faces as Bevy's irradiance volumes have
/// them, (R, 2 R, 3 R), one cascade behind the other; and, where the pixel's shader is ours, one
/// more slice that says so (its depth is then no multiple of three, as no irradiance volume's is).
pub(crate) fn texture_size(settings: &VoxelGiVolume, patched: bool) -> Extent3d {
    let r = settings.resolution;
    Extent3d {
        width: r,
        height: 2 * r,
        depth_or_array_layers: if patched {
            3 * r * settings.cascades + 1
        } else {
            3 * r
        },
    }
}

/// An empty one.
pub(super) fn texture(size: Extent3d) -> Image {
    let mut image = Image::new_uninit(
        size,
        TextureDimension::D3,
        TextureFormat::Rgba16Float,
        RenderAssetUsages::RENDER_WORLD,
    );
    image.texture_descriptor.label = Some("voxel_gi_light");
    image.texture_descriptor.usage = TextureUsages::TEXTURE_BINDING
        | TextureUsages::STORAGE_BINDING
        | TextureUsages::COPY_SRC
        | TextureUsages::COPY_DST;
    image.sampler = ImageSampler::Descriptor(ImageSamplerDescriptor {
        address_mode_u: ImageAddressMode::ClampToEdge,
        address_mode_v: ImageAddressMode::ClampToEdge,
        address_mode_w: ImageAddressMode::ClampToEdge,
        ..ImageSamplerDescriptor::linear()
    });
    image
}

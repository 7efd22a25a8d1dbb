//! Writes where the anchor of cascades is, also in frames in which nothing else is computed.

use bevy::{
    prelude::*,
    render::{
        render_asset::RenderAssets,
        render_resource::{
            Extent3d, Origin3d, TexelCopyBufferLayout, TexelCopyTextureInfo, TextureAspect,
            TextureId,
        },
        renderer::RenderQueue,
        texture::GpuImage,
    },
};
use half::f16;

use crate::extract::volume::ExtractedVolume;

/// Writes it from the middle of the largest cascade, in its voxels. Keep in sync with `cascades_light` in `receive.wesl`.
pub(crate) fn write_anchor(
    volume: Res<ExtractedVolume>,
    images: Res<RenderAssets<GpuImage>>,
    queue: Res<RenderQueue>,
    mut known: Local<Option<(TextureId, Vec3)>>,
) {
    let Some(volume) = volume.0.as_ref().filter(|volume| volume.patched) else {
        return;
    };
    let [_, .., largest] = volume.lit() else {
        return;
    };
    let Some(image) = images.get(&volume.texture) else {
        return;
    };
    let offset = (volume.anchor - largest.center) / volume.voxel_size(largest);
    // What is not finite has no cascades around it.
    let offset = if offset.is_finite() {
        offset
    } else {
        Vec3::ZERO
    };
    let now = Some((image.texture.id(), offset));
    if std::mem::replace(&mut *known, now) == now {
        return;
    }
    let size = image.texture_descriptor.size;
    let texel = offset
        .extend(0.0)
        .to_array()
        .map(|x| f16::from_f32(x).to_le_bytes());
    queue.write_texture(
        TexelCopyTextureInfo {
            texture: &image.texture,
            mip_level: 0,
            origin: Origin3d {
                x: 0,
                y: size.height - 2,
                z: size.depth_or_array_layers - 1,
            },
            aspect: TextureAspect::All,
        },
        texel.as_flattened(),
        TexelCopyBufferLayout::default(),
        Extent3d {
            width: 1,
            height: 1,
            depth_or_array_layers: 1,
        },
    );
}

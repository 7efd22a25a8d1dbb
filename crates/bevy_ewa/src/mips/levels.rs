//! A texture whose levels are generated.

use bevy::{
    prelude::*,
    render::render_resource::{
        Texture, TextureFormat, TextureView, TextureViewDescriptor, TextureViewDimension,
    },
};

/// A texture, and how many of its levels are generated.
pub(crate) struct Levels<'a> {
    pub texture: &'a Texture,
    /// Format of the views: an sRGB format where the texels are sRGB.
    pub format: TextureFormat,
    /// Number of levels, the finest included.
    pub count: u32,
}

impl Levels<'_> {
    pub(super) fn view(&self, level: u32, layer: u32) -> TextureView {
        view(self.texture, Some(self.format), level, layer)
    }

    pub(super) fn size(&self, level: u32) -> [u32; 2] {
        [self.texture.width(), self.texture.height()].map(|side| (side >> level).max(1))
    }
}

/// The view of one level and layer.
pub(super) fn view(
    texture: &Texture,
    format: Option<TextureFormat>,
    level: u32,
    layer: u32,
) -> TextureView {
    texture.create_view(&TextureViewDescriptor {
        format,
        dimension: Some(TextureViewDimension::D2),
        base_mip_level: level,
        mip_level_count: Some(1),
        base_array_layer: layer,
        array_layer_count: Some(1),
        ..default()
    })
}

//! What the quad of the error view is painted with.

use bevy::{
    asset::{AssetPath, embedded_asset, embedded_path},
    prelude::*,
    render::render_resource::AsBindGroup,
    shader::ShaderRef,
    sprite_render::Material2d,
};

/// The largest difference of a channel of two pictures in sRGB, times a gain, in the colours of
/// [`absolute_error_heat_map`](crate::metrics::heat_map::absolute_error_heat_map).
#[derive(Asset, TypePath, AsBindGroup, Clone, Debug)]
pub struct ErrorMaterial {
    /// The picture without the plugin.
    #[texture(0)]
    pub before: Handle<Image>,
    /// That with it, of the same size.
    #[texture(1)]
    pub after: Handle<Image>,
    /// Pale yellow is a difference of `1 / gain` of the full range. 1 or more.
    #[uniform(2)]
    pub gain: f32,
}

impl Material2d for ErrorMaterial {
    fn fragment_shader() -> ShaderRef {
        ShaderRef::Path(AssetPath::from(embedded_path!("error.wesl")).with_source("embedded"))
    }
}

/// Puts the shader into the binary.
pub fn embed(app: &mut App) {
    embedded_asset!(app, "error.wesl");
}

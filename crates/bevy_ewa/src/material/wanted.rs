//! What the materials that show a texture want of it.

use bevy::{image::ImageSamplerDescriptor, render::render_resource::TextureFormat};

use crate::mips::MipContent;

/// What the renderer has to do for a texture.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct WantedTexture {
    /// Levels to generate, the finest included; 1 for none.
    pub levels: u32,
    pub format: TextureFormat,
    pub content: MipContent,
    /// The sampler in place of the image's.
    pub sampler: Option<ImageSamplerDescriptor>,
    pub after_draws: bool,
}

/// What a texture is taken for that materials show as different contents.
pub(super) fn stricter(a: MipContent, b: MipContent) -> MipContent {
    let rank = |content| match content {
        MipContent::Values => 0.0,
        MipContent::Transparent => 1.0,
        MipContent::Mask { cutoff } => 2.0 + cutoff,
        MipContent::Normals => f32::INFINITY,
    };
    if rank(a) < rank(b) { b } else { a }
}

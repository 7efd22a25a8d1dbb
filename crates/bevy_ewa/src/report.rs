//! What each texture of the filtered materials got.

use std::collections::HashMap;

use bevy::prelude::*;

use crate::mips::NoMips;

/// What the textures of the filtered materials got, and why not. It changes only when they do.
#[derive(Resource, Clone, Debug, Default, Reflect)]
#[reflect(Resource, Default, Debug, Clone)]
pub struct EwaReport {
    /// The textures, by their images.
    pub textures: HashMap<AssetId<Image>, TextureReport>,
}

/// What a texture got.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Debug, PartialEq)]
pub struct TextureReport {
    /// The mip levels.
    pub mips: MipReport,
    /// The `anisotropy_clamp` of its sampler: that of the image, or a higher one. Samplers that filter otherwise than
    /// linearly keep theirs.
    pub anisotropy: u16,
    /// Whether a material filters it by ellipses, in the shader.
    pub is_elliptical: bool,
}

/// The mip levels of a texture.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Debug, PartialEq)]
#[non_exhaustive]
pub enum MipReport {
    /// The image came with this many levels.
    Own(u32),
    /// The plugin generates this many levels, the finest included.
    Generated(u32),
    /// There are none but the finest.
    Without(NoMips),
}

impl MipReport {
    /// Returns the number of levels.
    pub fn levels(self) -> u32 {
        match self {
            Self::Own(levels) | Self::Generated(levels) => levels,
            Self::Without(_) => 1,
        }
    }
}

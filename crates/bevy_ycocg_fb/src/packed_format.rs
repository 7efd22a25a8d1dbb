//! The packed formats on the GPU: their texture formats and shader defs.

use bevy::{render::render_resource::TextureFormat, shader::ShaderDefVal};

use crate::settings::PackedFormat;

/// Shader def under which shaders write or read packed colours.
pub(crate) const PACK: &str = "YCOCG_FB_PACK";
const UNORM8: &str = "YCOCG_FB_UNORM8";

impl PackedFormat {
    /// All packed formats.
    pub const ALL: [Self; 3] = [Self::Float16, Self::Float32, Self::Unorm8];

    /// Returns the format of the packed texture.
    pub fn texture_format(self) -> TextureFormat {
        match self {
            Self::Float16 => TextureFormat::Rg16Float,
            Self::Float32 => TextureFormat::Rg32Float,
            Self::Unorm8 => TextureFormat::Rg8Unorm,
        }
    }

    /// Returns the shader defs of all shaders that write or read the packed texture.
    pub(crate) fn shader_defs(self) -> Vec<ShaderDefVal> {
        let mut defs = vec![PACK.into()];
        if self == Self::Unorm8 {
            defs.push(UNORM8.into());
        }
        defs
    }
}

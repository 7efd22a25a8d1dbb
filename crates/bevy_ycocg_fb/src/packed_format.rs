//! The formats on the GPU: their texture formats and shader defs.

use bevy::{render::render_resource::TextureFormat, shader::ShaderDefVal};

use crate::settings::{FrameBufferFormat, PackedFormat};

/// Shader def under which shaders write or read packed colours.
pub(crate) const PACK: &str = "YCOCG_FB_PACK";
const FLOAT32: &str = "YCOCG_FB_FLOAT32";
const UNORM8: &str = "YCOCG_FB_UNORM8";
/// Shader def under which shaders round colours, with dither, to those of `Rg11b10Ufloat`.
pub(crate) const RG11B10UFLOAT: &str = "YCOCG_FB_RG11B10UFLOAT";

impl FrameBufferFormat {
    /// Returns the format of the texture that is drawn to.
    pub fn texture_format(self) -> TextureFormat {
        match self {
            Self::Packed(format) => format.texture_format(),
            Self::Rg11b10Ufloat => TextureFormat::Rg11b10Ufloat,
        }
    }
}

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
        let format = match self {
            Self::Float16 => None,
            Self::Float32 => Some(FLOAT32),
            Self::Unorm8 => Some(UNORM8),
        };
        let names = [PACK].into_iter().chain(format);
        names.map(ShaderDefVal::from).collect()
    }
}

//! The formats on the GPU: their texture formats, and the shader defs by which a material's pipeline packs or rounds.

use bevy::{
    mesh::BaseMeshPipelineKey,
    pbr::MeshPipelineKey,
    render::render_resource::{RenderPipelineDescriptor, TextureFormat},
    shader::ShaderDefVal,
};
use bevy_frugal_hooks::SpecializedMaterial;

use crate::settings::{FrameBufferFormat, PackedFormat};

/// Shader def under which shaders write or read packed colours.
pub(crate) const PACK: &str = "YCOCG_FB_PACK";
const FLOAT32: &str = "YCOCG_FB_FLOAT32";
const UNORM8: &str = "YCOCG_FB_UNORM8";
/// Shader def under which shaders round colours, with dither, to those of `Rg11b10Ufloat`.
pub(crate) const RG11B10UFLOAT: &str = "YCOCG_FB_RG11B10UFLOAT";
/// Shader def of materials whose alpha selects samples, and the number of samples per pixel.
const COVERAGE: &str = "YCOCG_FB_COVERAGE";
const SAMPLES: &str = "YCOCG_FB_SAMPLES";
/// Shader defs of Bevy's dither, by steps of a display, and of that by steps of the packed format.
const BEVYS_DITHER: &str = "DEBAND_DITHER";
const DITHER: &str = "YCOCG_FB_DITHER";

/// Flag of views with a format of this crate in Bevy's `MeshPipelineKey`, a bit that Bevy does not use.
pub(crate) const PACKED_KEY: u64 = 1 << 57;
const _: () = assert!(
    (MeshPipelineKey::all().bits() | BaseMeshPipelineKey::all().bits()) & PACKED_KEY == 0,
    "Bevy has taken the bit: choose another"
);

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

/// The material hook, by which a material's pipeline for a camera with another format writes that format's
/// colours.
pub(crate) fn pack_for_packed_targets(
    material: SpecializedMaterial,
    descriptor: &mut RenderPipelineDescriptor,
) {
    if material.mesh_key.bits() & PACKED_KEY == 0 {
        return;
    }
    let target_format = material.mesh_key.target_format();
    if target_format == FrameBufferFormat::Rg11b10Ufloat.texture_format()
        && let Some(fragment) = &mut descriptor.fragment
    {
        fragment.shader_defs.push(RG11B10UFLOAT.into());
    }
    let packed = PackedFormat::ALL
        .into_iter()
        .find(|format| format.texture_format() == target_format);
    if let Some(format) = packed {
        pack(descriptor, format);
    }
}

/// Sets the target format and the shader defs of a pipeline for packed colours. Its shader must support
/// them.
pub(crate) fn pack(descriptor: &mut RenderPipelineDescriptor, format: PackedFormat) {
    let Some(fragment) = &mut descriptor.fragment else {
        return;
    };
    let Some(Some(target)) = fragment.targets.first_mut() else {
        return;
    };
    target.format = format.texture_format();
    if format != PackedFormat::Unorm8 {
        // Packed colours are scene-linear; tone mapping follows the reconstruction.
        fragment.shader_defs.retain(|def| !is_tone_mapping(def));
    } else if let Some(dither) = fragment
        .shader_defs
        .iter_mut()
        .find(|def| matches!(def, ShaderDefVal::Bool(name, true) if name == BEVYS_DITHER))
    {
        *dither = DITHER.into();
    }
    fragment.shader_defs.extend(format.shader_defs());
    let multisample = &descriptor.multisample;
    if multisample.alpha_to_coverage_enabled && multisample.count > 1 {
        let samples = ShaderDefVal::UInt(SAMPLES.into(), multisample.count);
        fragment.shader_defs.extend([COVERAGE.into(), samples]);
    }
}

/// Whether a pipeline has the shader def and the target of this format. Its shader may still not pack.
pub(crate) fn packs(descriptor: &RenderPipelineDescriptor, format: PackedFormat) -> bool {
    let has_def = descriptor
        .fragment
        .as_ref()
        .is_none_or(|fragment| fragment.shader_defs.contains(&PACK.into()));
    has_def && has_format(descriptor, format.into())
}

/// Whether the target of a pipeline has the format, whatever it writes.
pub(crate) fn has_format(descriptor: &RenderPipelineDescriptor, format: FrameBufferFormat) -> bool {
    let target = descriptor
        .fragment
        .as_ref()
        .and_then(|fragment| fragment.targets.first());
    target
        .and_then(Option::as_ref)
        .is_some_and(|target| target.format == format.texture_format())
}

fn is_tone_mapping(def: &ShaderDefVal) -> bool {
    let ShaderDefVal::Bool(name, _) = def else {
        return false;
    };
    name == "TONEMAP_IN_SHADER" || name == BEVYS_DITHER || name.starts_with("TONEMAP_METHOD_")
}

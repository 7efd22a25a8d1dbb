//! The shader def that makes a material's pipeline pack, for packed cameras only.

use bevy::{
    mesh::BaseMeshPipelineKey,
    pbr::MeshPipelineKey,
    prelude::*,
    render::render_resource::{RenderPipelineDescriptor, TextureFormat},
    shader::ShaderDefVal,
};
use bevy_frugal_hooks::SpecializedMaterial;

use crate::settings::PackedFormat;

const PACK: &str = "YCOCG_FB_PACK";
const UNORM8: &str = "YCOCG_FB_UNORM8";

impl PackedFormat {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Float16, Self::Float32, Self::Unorm8];

    /// The format of the packed texture.
    pub fn texture_format(self) -> TextureFormat {
        match self {
            Self::Float16 => TextureFormat::Rg16Float,
            Self::Float32 => TextureFormat::Rg32Float,
            Self::Unorm8 => TextureFormat::Rg8Unorm,
        }
    }

    /// The shader defs of all shaders that write or read it.
    pub(crate) fn shader_defs(self) -> Vec<ShaderDefVal> {
        let mut defs = vec![PACK.into()];
        if self == Self::Unorm8 {
            defs.push(UNORM8.into());
        }
        defs
    }
}

/// A bit of Bevy's `MeshPipelineKey` that Bevy leaves free: the view is packed.
pub(crate) const PACKED_KEY: u64 = 1 << 57;
const _: () = assert!(
    (MeshPipelineKey::all().bits() | BaseMeshPipelineKey::all().bits()) & PACKED_KEY == 0,
    "Bevy has taken the bit: choose another"
);

/// The hook: a material's pipeline for a packed camera writes packed colours.
pub(crate) fn pack_for_packed_targets(
    material: SpecializedMaterial,
    descriptor: &mut RenderPipelineDescriptor,
) {
    if material.mesh_key.bits() & PACKED_KEY == 0 {
        return;
    }
    let target_format = material.mesh_key.target_format();
    let packed = PackedFormat::ALL
        .into_iter()
        .find(|format| format.texture_format() == target_format);
    if let Some(format) = packed {
        pack(descriptor, format);
    }
}

/// Makes a pipeline write packed colours, as far as its shader can.
pub(crate) fn pack(descriptor: &mut RenderPipelineDescriptor, format: PackedFormat) {
    let Some(fragment) = &mut descriptor.fragment else {
        return;
    };
    let Some(Some(target)) = fragment.targets.first_mut() else {
        return;
    };
    target.format = format.texture_format();
    if format != PackedFormat::Unorm8 {
        // What is packed is scene-linear; tone mapping follows the reconstruction.
        fragment.shader_defs.retain(|def| !is_tone_mapping(def));
    }
    fragment.shader_defs.extend(format.shader_defs());
}

/// Whether a pipeline was made to pack into this format, if its shader can.
pub(crate) fn packs(descriptor: &RenderPipelineDescriptor, format: PackedFormat) -> bool {
    let has_def = descriptor
        .fragment
        .as_ref()
        .is_none_or(|fragment| fragment.shader_defs.contains(&PACK.into()));
    has_def && fits(descriptor, format)
}

/// Whether a pipeline can draw to a packed texture, whatever it writes.
pub(crate) fn fits(descriptor: &RenderPipelineDescriptor, format: PackedFormat) -> bool {
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
    name == "TONEMAP_IN_SHADER" || name == "DEBAND_DITHER" || name.starts_with("TONEMAP_METHOD_")
}

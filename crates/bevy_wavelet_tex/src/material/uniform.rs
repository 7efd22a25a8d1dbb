//! What the shader must know of the textures; the same names in `decode.wgsl` and `bindings.wgsl`.

use bevy::{
    math::{UVec2, Vec3},
    render::render_resource::ShaderType,
};

use super::extension::WaveletAddressMode;
use crate::{
    asset::{WaveletStorage, WaveletTexture},
    codec::{
        image::{ColorSpace, Content},
        quantizer::PlaneCoding,
    },
};

/// `WaveletMaterial` in `bindings.wgsl`.
#[derive(Clone, Copy, Default, ShaderType)]
pub(super) struct MaterialUniform {
    pub(super) base_color: TextureUniform,
    pub(super) normal: TextureUniform,
    pub(super) mask: TextureUniform,
}

/// `WaveletTexture` in `decode.wgsl`.
#[derive(Clone, Copy, Default, ShaderType)]
pub(super) struct TextureUniform {
    size: UVec2,
    levels: u32,
    kind: u32,
    srgb: u32,
    address: u32,
    planes: [PlaneUniform; 3],
}

/// `PlaneCoding` in `decode.wgsl`.
#[derive(Clone, Copy, Default, ShaderType)]
struct PlaneUniform {
    unmix_hl: Vec3,
    mean_min: f32,
    unmix_lh: Vec3,
    mean_extent: f32,
    unmix_hh: Vec3,
    range: f32,
    inverse_gamma: f32,
}

impl TextureUniform {
    pub(super) fn new(texture: &WaveletTexture) -> Self {
        let kind = match (texture.storage, texture.content) {
            (WaveletStorage::Blocks, Content::Gray) => 0,
            (WaveletStorage::Blocks, Content::Color) => 1,
            (WaveletStorage::Blocks, Content::Normal) => 2,
            (WaveletStorage::Decoded, Content::Gray | Content::Color) => 3,
            (WaveletStorage::Decoded, Content::Normal) => 4,
        };
        let srgb = texture.color_space == ColorSpace::Srgb && texture.content != Content::Normal;
        let mut planes = [PlaneUniform::default(); 3];
        for (plane, coding) in planes.iter_mut().zip(&texture.codings) {
            *plane = PlaneUniform::new(coding);
        }
        Self {
            size: texture.size.into(),
            levels: texture.levels,
            kind,
            srgb: srgb.into(),
            address: 0,
            planes,
        }
    }

    pub(super) fn addressed(self, address: WaveletAddressMode) -> Self {
        let address = match address {
            WaveletAddressMode::Repeat => 0,
            WaveletAddressMode::ClampToEdge => 1,
            WaveletAddressMode::MirrorRepeat => 2,
        };
        Self { address, ..self }
    }
}

impl PlaneUniform {
    fn new(coding: &PlaneCoding) -> Self {
        let [unmix_hl, unmix_lh, unmix_hh] = coding.transform.unmix_rows().map(Vec3::from);
        Self {
            unmix_hl,
            mean_min: coding.mean_min,
            unmix_lh,
            mean_extent: coding.mean_max - coding.mean_min,
            unmix_hh,
            range: coding.range,
            inverse_gamma: 1.0 / coding.gamma,
        }
    }
}

//! The uniforms of the shaders, with the same field names as in `types.wesl` and `bindings.wesl`.

use bevy::{
    math::{UVec2, Vec3},
    render::render_resource::ShaderType,
};

use crate::{
    asset::WaveletTexture,
    codec::{
        image::{ColorSpace, Content},
        packing::Packing,
        quantizer::PlaneCoding,
    },
    settings::{WaveletAddressMode, WaveletStorage},
};

/// The uniform of a material, `WaveletMaterial` in `bindings.wesl`.
#[derive(Clone, Copy, Default, ShaderType)]
pub(super) struct MaterialUniform {
    pub(super) base_color: TextureUniform,
    pub(super) emissive: TextureUniform,
    pub(super) normal: TextureUniform,
    pub(super) metallic_roughness: TextureUniform,
    pub(super) occlusion: TextureUniform,
    pub(super) mask: TextureUniform,
}

/// The parameters of a texture, `WaveletTexture` in `types.wesl`.
#[derive(Clone, Copy, Default, ShaderType)]
pub(super) struct TextureUniform {
    size: UVec2,
    levels: u32,
    kind: u32,
    srgb: u32,
    address: u32,
    luma_packing: u32,
    chroma_packing: u32,
    subsampling: u32,
    whole: u32,
    planes: [PlaneUniform; 4],
}

/// The parameters of a plane, `PlaneCoding` in `types.wesl`.
#[derive(Clone, Copy, Default, ShaderType)]
struct PlaneUniform {
    unmix_hl: Vec3,
    low_min: f32,
    unmix_lh: Vec3,
    low_extent: f32,
    unmix_hh: Vec3,
    range: f32,
    zero_point: Vec3,
    inverse_gamma: f32,
    predictor: f32,
}

impl TextureUniform {
    pub(super) fn new(texture: &WaveletTexture) -> Self {
        let kind = match (texture.storage, texture.content) {
            (WaveletStorage::Blocks, Content::Gray) => 0,
            (WaveletStorage::Blocks, Content::Color) => 1,
            (WaveletStorage::Blocks, Content::Normal) => 2,
            (WaveletStorage::Blocks, Content::ColorAlpha) => 3,
            (WaveletStorage::Decoded, Content::Normal) => 5,
            (WaveletStorage::Decoded, _) => 4,
        };
        let srgb = texture.color_space == ColorSpace::Srgb && texture.content != Content::Normal;
        let [luma, chroma @ ..] = texture.groups.as_slice() else {
            return Self::default();
        };
        let chroma = chroma.first();
        let mut planes = [PlaneUniform::default(); 4];
        let codings = luma.codings.iter();
        for (plane, coding) in planes.iter_mut().zip(codings) {
            *plane = PlaneUniform::new(coding);
        }
        let codings = chroma.iter().flat_map(|group| &group.codings);
        for (plane, coding) in planes[2..].iter_mut().zip(codings) {
            *plane = PlaneUniform::new(coding);
        }
        let packing = |packing: Packing| {
            let mut all = Packing::ALL.iter();
            all.position(|p| *p == packing).expect("ALL has all") as u32
        };
        Self {
            size: texture.size.into(),
            levels: texture.levels,
            kind,
            srgb: srgb.into(),
            address: 0,
            luma_packing: packing(luma.packing),
            chroma_packing: chroma.map_or(0, |group| packing(group.packing)),
            subsampling: chroma.map_or(0, |group| group.subsampling),
            whole: texture.is_whole().into(),
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
            low_min: coding.low_min,
            unmix_lh,
            low_extent: coding.low_max - coding.low_min,
            unmix_hh,
            range: coding.range,
            zero_point: coding.zero_point.into(),
            inverse_gamma: 1.0 / coding.gamma,
            predictor: coding.predictor,
        }
    }
}

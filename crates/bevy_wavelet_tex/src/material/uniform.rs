//! The uniforms of the shaders, with the same field names as in `types.wesl` and `bindings.wesl`.

use bevy::{
    math::{IVec4, Mat3, UVec2, UVec4, Vec2, Vec3},
    render::render_resource::ShaderType,
};

use crate::{
    asset::{MipAtlas, WaveletTexture},
    codec::quantizer::PlaneCoding,
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
    form: u32,
    subsampling: u32,
    luma_atlas: AtlasUniform,
    chroma_atlas: AtlasUniform,
    planes: [PlaneUniform; 4],
    axes: Mat3,
}

/// The place of mip levels, `MipAtlas` in `types.wesl`.
#[derive(Clone, Copy, Default, ShaderType)]
struct AtlasUniform {
    second_and_block: IVec4,
    texel: Vec2,
    stack: i32,
    tail: i32,
}

/// The parameters of a plane, `PlaneCoding` in `types.wesl`.
#[derive(Clone, Copy, Default, ShaderType)]
struct PlaneUniform {
    unmix_hl: Vec3,
    low_min: f32,
    unmix_lh: Vec3,
    low_extent: f32,
    unmix_hh: Vec3,
    detail_scale: f32,
    zero_point: Vec3,
    inverse_gamma: f32,
    predictor: f32,
}

impl TextureUniform {
    pub(super) fn new(texture: &WaveletTexture) -> Self {
        let mut planes = [PlaneUniform::default(); 4];
        let groups = texture.parameters.groups();
        for (group, first) in groups.into_iter().zip([0, 2]) {
            let Some(group) = group else {
                continue;
            };
            for (plane, coding) in planes[first..].iter_mut().zip(&group.codings) {
                *plane = PlaneUniform::new(coding);
            }
        }
        let [luma_atlas, chroma_atlas] = groups.map(|group| {
            let atlas = group.map(|group| texture.atlas(group));
            atlas.map_or_else(AtlasUniform::default, AtlasUniform::new)
        });
        Self {
            size: texture.size.into(),
            levels: texture.levels,
            form: 0,
            subsampling: groups[1].map_or(0, |group| group.subsampling),
            luma_atlas,
            chroma_atlas,
            planes,
            axes: Mat3::from_cols_array_2d(&texture.parameters.axes().rgb),
        }
    }

    /// The same with the bits of its form.
    pub(super) fn of_form(self, form: u32) -> Self {
        Self { form, ..self }
    }
}

impl AtlasUniform {
    fn new(atlas: MipAtlas) -> Self {
        Self {
            second_and_block: UVec4::new(
                atlas.second[0],
                atlas.second[1],
                atlas.block[0],
                atlas.block[1],
            )
            .as_ivec4(),
            texel: UVec2::from(atlas.size).as_vec2().recip(),
            stack: atlas.stack as i32,
            tail: atlas.tail as i32,
        }
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
            detail_scale: 0.5 * coding.range * (1.0 / coding.gamma).exp2(),
            zero_point: coding.zero_point.into(),
            inverse_gamma: 1.0 / coding.gamma,
            predictor: coding.predictor,
        }
    }
}

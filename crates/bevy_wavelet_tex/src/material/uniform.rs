//! What shaders know of a texture: the uniforms, with the same field names as in `types.wesl` and `bindings.wesl`, and
//! what decides which code decodes it, as a number that is a constant in shaders.

use bevy::{
    math::{IVec4, Mat3, UVec2, UVec4, Vec2, Vec3},
    render::render_resource::ShaderType,
};

use crate::{
    asset::{MipAtlas, PlainParameters, TextureGroup, TextureParameters, WaveletTexture},
    codec::{
        haar::Transform,
        image::{ColorSpace, Content},
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
        let [second, block] = [atlas.second, atlas.block].map(UVec2::from);
        Self {
            second_and_block: UVec4::from((second, block)).as_ivec4(),
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

/// The form of a texture: its packings and its kind, but none of its numbers. Pipelines are
/// specialised by it. The bits are those of `types.wesl`; 0 is no texture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct TextureForm(u32);

const PACKING: u32 = 7;
const PACKING_SPLIT: u32 = 2;
const CODING_BITS: u32 = 6;
const CODING_PREDICTED: u32 = 1 << 3;
const CODING_CURVED: u32 = 1 << 4;
const CODING_MIXED: u32 = 1 << 5;
const PLAIN_OPAQUE: u32 = 1;
const PLAIN_SCALED: u32 = 1 << 1;
const PLAIN_PADDED: u32 = 1 << 2;
const KIND_SHIFT: u32 = 12;
const KIND_COLOR: u32 = 1;
const KIND_COLOR_ALPHA: u32 = 3;
const KIND_DECODED: u32 = 4;
const KIND_DECODED_NORMAL: u32 = 5;
const KIND_PLAIN_GRAY: u32 = 6;
const KIND_PLAIN_NORMAL: u32 = 7;
const SRGB: u32 = 1 << 15;
const MIPS: u32 = 1 << 16;
const ADDRESS_SHIFT: u32 = 17;
const AXES: u32 = 1 << 19;
const PRESENT: u32 = 1 << 31;

impl TextureForm {
    /// That of a texture that is not bound for its map: another map's is sampled for both, or it is of no use there.
    pub(super) const UNBOUND: Self = Self(1 << 30);

    pub(super) fn new(texture: &WaveletTexture) -> Self {
        if let (WaveletStorage::Blocks, TextureParameters::Plain(plain)) =
            (texture.storage, &texture.parameters)
        {
            return Self::plain(texture, *plain);
        }
        let kind = match (texture.storage, texture.content) {
            (WaveletStorage::Blocks, Content::Gray) => 0,
            (WaveletStorage::Blocks, Content::Color) => KIND_COLOR,
            (WaveletStorage::Blocks, Content::Normal) => 2,
            (WaveletStorage::Blocks, Content::ColorAlpha) => KIND_COLOR_ALPHA,
            (WaveletStorage::Decoded, Content::Normal) => {
                return Self(PRESENT | KIND_DECODED_NORMAL << KIND_SHIFT);
            }
            (WaveletStorage::Decoded, _) => return Self(PRESENT | KIND_DECODED << KIND_SHIFT),
        };
        let [luma, chroma] = texture
            .parameters
            .groups()
            .map(|group| group.map_or(0, coding));
        let srgb = texture.color_space == ColorSpace::Srgb && texture.content != Content::Normal;
        let mut form = PRESENT | luma | chroma << CODING_BITS | kind << KIND_SHIFT;
        form |= if srgb { SRGB } else { 0 };
        form |= if texture.levels > 1 { MIPS } else { 0 };
        let has_axes = texture.content.has_chroma() && !texture.parameters.axes().are_ycocg();
        form |= if has_axes { AXES } else { 0 };
        Self(form)
    }

    /// That of a texture without a wavelet, which the texture unit filters as a decoded one where it can.
    /// The shader linearises the rest.
    fn plain(texture: &WaveletTexture, plain: PlainParameters) -> Self {
        let is_gray = texture.content == Content::Gray;
        let (kind, is_opaque) = match texture.content {
            Content::Color => (KIND_DECODED, true),
            Content::ColorAlpha => (KIND_DECODED, false),
            Content::Gray => (KIND_PLAIN_GRAY, false),
            Content::Normal => (KIND_PLAIN_NORMAL, false),
        };
        let is_encoded = texture.color_space == ColorSpace::Srgb && (is_gray || plain.is_scaled);
        let mut form = PRESENT | kind << KIND_SHIFT;
        form |= if is_opaque { PLAIN_OPAQUE } else { 0 };
        form |= if plain.is_scaled { PLAIN_SCALED } else { 0 };
        form |= match (plain.is_padded, texture.levels) {
            (true, 2..) => PLAIN_PADDED | MIPS,
            (true, _) => PLAIN_PADDED,
            (false, _) => 0,
        };
        let is_srgb = is_encoded && texture.content != Content::Normal;
        form |= if is_srgb { SRGB } else { 0 };
        Self(form)
    }

    /// The bits with those of an address mode, which are its number.
    pub(super) fn bits(self, address: WaveletAddressMode) -> u32 {
        self.0 | (address as u32) << ADDRESS_SHIFT
    }
}

/// Whether the bits of a form are those of a texture of several images: chroma, or detail bands, beside luma.
pub(super) fn has_planes(form: u32) -> bool {
    match form >> KIND_SHIFT & 7 {
        KIND_COLOR | KIND_COLOR_ALPHA => true,
        KIND_DECODED.. => false,
        _ => form & PACKING == PACKING_SPLIT,
    }
}

/// The coding of a group of planes. Planes of one group share it: where only one of them needs some
/// code, all run through it, with numbers that change nothing.
fn coding(group: &TextureGroup) -> u32 {
    let packing = group.packing as u32;
    if !group.packing.is_wavelet() {
        return packing;
    }
    let flag = |flag, needed: fn(&PlaneCoding) -> bool| match group.codings.iter().any(needed) {
        true => flag,
        false => 0,
    };
    packing
        | flag(CODING_PREDICTED, |c| c.predictor != 0.0)
        | flag(CODING_CURVED, |c| c.gamma != 1.0)
        | flag(CODING_MIXED, |c| c.transform != Transform::Haar)
}

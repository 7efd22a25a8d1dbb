//! What decides which code decodes a texture, as a number that is a constant in shaders.

use crate::{
    asset::{PlainParameters, TextureGroup, TextureParameters, WaveletTexture},
    codec::{
        haar::Transform,
        image::{ColorSpace, Content},
        packing::Packing,
        quantizer::PlaneCoding,
    },
    settings::{WaveletAddressMode, WaveletStorage},
};

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
        form |= if is_encoded && texture.content != Content::Normal {
            SRGB
        } else {
            0
        };
        Self(form)
    }

    pub(super) fn bits(self, address: WaveletAddressMode) -> u32 {
        let address = match address {
            WaveletAddressMode::Repeat => 0,
            WaveletAddressMode::ClampToEdge => 1,
            WaveletAddressMode::MirrorRepeat => 2,
        };
        self.0 | address << ADDRESS_SHIFT
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
    let mut all = Packing::ALL.iter();
    let packing = all.position(|p| *p == group.packing).expect("ALL has all") as u32;
    if !group.packing.is_wavelet() {
        return packing;
    }
    let flag = |flag, needed: fn(&PlaneCoding) -> bool| {
        if group.codings.iter().any(needed) {
            flag
        } else {
            0
        }
    };
    packing
        | flag(CODING_PREDICTED, |c| c.predictor != 0.0)
        | flag(CODING_CURVED, |c| c.gamma != 1.0)
        | flag(CODING_MIXED, |c| c.transform != Transform::Haar)
}

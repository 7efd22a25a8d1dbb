// What a shader must know of a wavelet texture; uniform.rs fills it.

#define_import_path bevy_wavelet_tex::types

// How the values of one plane are stored. `PlaneUniform` in uniform.rs.
struct PlaneCoding {
    // Rows of the matrix from stored details to HL, LH, HH.
    unmix_hl: vec3<f32>,
    // Mean that 0 stands for.
    mean_min: f32,
    unmix_lh: vec3<f32>,
    // 1 stands for mean_min + mean_extent.
    mean_extent: f32,
    unmix_hh: vec3<f32>,
    // Largest stored detail.
    range: f32,
    // What a detail of zero is stored as.
    centre: vec3<f32>,
    // Exponent that undoes the power curve.
    inverse_gamma: f32,
    // How much of the details the neighbours' means foretell; 0 is not at all.
    predictor: f32,
}

// One texture. `TextureUniform` in uniform.rs.
struct WaveletTexture {
    // Width and height of the image, in pixels.
    size: vec2<u32>,
    levels: u32,
    // KIND_*
    kind: u32,
    // 1 where values are sRGB-encoded, 0 where they are data.
    srgb: u32,
    // ADDRESS_*
    address: u32,
    // PACKING_* of luma (with alpha), gray, or the X and Y of normals.
    luma_packing: u32,
    // PACKING_* of chroma.
    chroma_packing: u32,
    // How often chroma is halved.
    subsampling: u32,
    // 1 where the textures hold nothing but the image, so that their sampler can repeat them.
    whole: u32,
    // Luma, alpha or gray or X, Y; then Co, Cg.
    planes: array<PlaneCoding, 4>,
}

const KIND_GRAY = 0u;
const KIND_COLOR = 1u;
const KIND_NORMAL = 2u;
const KIND_COLOR_ALPHA = 3u;
// Decoded on load, where the adapter lacks BC: luma holds the pixels, normals as 0.5 + 0.5 n.
const KIND_DECODED = 4u;
const KIND_DECODED_NORMAL = 5u;

// Details in RGB, the mean in A.
const PACKING_BC3 = 0u;
// HL, LH, and the mean in B.
const PACKING_BC7 = 1u;
// The mean in R; details in a texture of their own.
const PACKING_SPLIT = 2u;
// No wavelet: a texel is a pixel.
const PACKING_BC4 = 3u;
// No wavelet: two planes in a texel, the first in R and B.
const PACKING_BC1 = 4u;

const ADDRESS_REPEAT = 0u;
const ADDRESS_CLAMP = 1u;
const ADDRESS_MIRROR = 2u;

// Size of a mip level in pixels.
fn level_size(texture: WaveletTexture, level: u32) -> vec2<u32> {
    return max(texture.size >> vec2(level), vec2(1u));
}

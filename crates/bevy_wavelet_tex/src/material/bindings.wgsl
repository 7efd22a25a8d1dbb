// The textures of `WaveletExtension`, and what a fragment takes from them. Bindings as in bind_group.rs.

#define_import_path bevy_wavelet_tex::bindings

#import bevy_wavelet_tex::types::WaveletTexture
#ifdef WAVELET_FILTER_ANISOTROPIC
#import bevy_wavelet_tex::anisotropic::sample_anisotropic
#else
#import bevy_wavelet_tex::sampling::sample
#endif

// `MaterialUniform` in uniform.rs.
struct WaveletMaterial {
    base_color: WaveletTexture,
    emissive: WaveletTexture,
    normal: WaveletTexture,
    metallic_roughness: WaveletTexture,
    occlusion: WaveletTexture,
    mask: WaveletTexture,
}

@group(#{MATERIAL_BIND_GROUP}) @binding(100) var<uniform> wavelet: WaveletMaterial;
@group(#{MATERIAL_BIND_GROUP}) @binding(101) var chroma_sampler: sampler;
@group(#{MATERIAL_BIND_GROUP}) @binding(102) var coefficient_sampler: sampler;
#ifdef WAVELET_BASE_COLOR
@group(#{MATERIAL_BIND_GROUP}) @binding(103) var base_color_luma: texture_2d_array<f32>;
@group(#{MATERIAL_BIND_GROUP}) @binding(104) var base_color_detail: texture_2d_array<f32>;
@group(#{MATERIAL_BIND_GROUP}) @binding(105) var base_color_chroma: texture_2d_array<f32>;
#endif
#ifdef WAVELET_EMISSIVE
@group(#{MATERIAL_BIND_GROUP}) @binding(106) var emissive_luma: texture_2d_array<f32>;
@group(#{MATERIAL_BIND_GROUP}) @binding(107) var emissive_detail: texture_2d_array<f32>;
@group(#{MATERIAL_BIND_GROUP}) @binding(108) var emissive_chroma: texture_2d_array<f32>;
#endif
#ifdef WAVELET_NORMAL
@group(#{MATERIAL_BIND_GROUP}) @binding(109) var normal_luma: texture_2d_array<f32>;
#endif
#ifdef WAVELET_METALLIC_ROUGHNESS
@group(#{MATERIAL_BIND_GROUP}) @binding(110) var metallic_roughness_luma: texture_2d_array<f32>;
@group(#{MATERIAL_BIND_GROUP}) @binding(111) var metallic_roughness_detail: texture_2d_array<f32>;
@group(#{MATERIAL_BIND_GROUP}) @binding(112) var metallic_roughness_chroma: texture_2d_array<f32>;
#endif
#ifdef WAVELET_OCCLUSION
@group(#{MATERIAL_BIND_GROUP}) @binding(113) var occlusion_luma: texture_2d_array<f32>;
@group(#{MATERIAL_BIND_GROUP}) @binding(114) var occlusion_detail: texture_2d_array<f32>;
#endif
#ifdef WAVELET_MASK
@group(#{MATERIAL_BIND_GROUP}) @binding(115) var mask_luma: texture_2d_array<f32>;
@group(#{MATERIAL_BIND_GROUP}) @binding(116) var mask_detail: texture_2d_array<f32>;
#endif

fn filtered(
    texture: WaveletTexture,
    luma: texture_2d_array<f32>,
    detail: texture_2d_array<f32>,
    chroma: texture_2d_array<f32>,
    uv: vec2<f32>,
    frag_coord: vec2<f32>,
    bias: f32,
) -> vec4<f32> {
#ifdef WAVELET_FILTER_ANISOTROPIC
    return sample_anisotropic(
        texture, luma, detail, chroma, chroma_sampler, coefficient_sampler, uv, frag_coord, bias,
    );
#else
    return sample(texture, luma, detail, chroma, chroma_sampler, uv, frag_coord, bias);
#endif
}

// What the base colour is multiplied by.
fn base_color_factor(uv: vec2<f32>, frag_coord: vec2<f32>, bias: f32) -> vec4<f32> {
    var factor = vec4(1.0);
#ifdef WAVELET_BASE_COLOR
    factor = filtered(
        wavelet.base_color, base_color_luma, base_color_detail, base_color_chroma,
        uv, frag_coord, bias,
    );
#endif
#ifdef WAVELET_MASK
    factor.a *= filtered(wavelet.mask, mask_luma, mask_detail, mask_luma, uv, frag_coord, bias).r;
#endif
    return factor;
}

// What the emitted light is multiplied by.
fn emissive_factor(uv: vec2<f32>, frag_coord: vec2<f32>, bias: f32) -> vec3<f32> {
#ifdef WAVELET_EMISSIVE
    return filtered(
        wavelet.emissive, emissive_luma, emissive_detail, emissive_chroma, uv, frag_coord, bias,
    ).rgb;
#else
    return vec3(1.0);
#endif
}

// What roughness (x) and metallic (y) are multiplied by: G and B, as in glTF.
fn roughness_metallic_factor(uv: vec2<f32>, frag_coord: vec2<f32>, bias: f32) -> vec2<f32> {
#ifdef WAVELET_METALLIC_ROUGHNESS
    return filtered(
        wavelet.metallic_roughness,
        metallic_roughness_luma,
        metallic_roughness_detail,
        metallic_roughness_chroma,
        uv,
        frag_coord,
        bias,
    ).gb;
#else
    return vec2(1.0);
#endif
}

// The share of indirect light that arrives: R, as in glTF.
fn occlusion(uv: vec2<f32>, frag_coord: vec2<f32>, bias: f32) -> f32 {
#ifdef WAVELET_OCCLUSION
    return filtered(
        wavelet.occlusion, occlusion_luma, occlusion_detail, occlusion_luma, uv, frag_coord, bias,
    ).r;
#else
    return 1.0;
#endif
}

#ifdef WAVELET_NORMAL
// The normal in tangent space, of unit length.
fn tangent_normal(uv: vec2<f32>, frag_coord: vec2<f32>, bias: f32) -> vec3<f32> {
    return normalize(filtered(
        wavelet.normal, normal_luma, normal_luma, normal_luma, uv, frag_coord, bias,
    ).xyz);
}
#endif

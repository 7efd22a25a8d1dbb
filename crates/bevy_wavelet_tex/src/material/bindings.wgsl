// The textures of `WaveletExtension`, and what a fragment takes from them.

#define_import_path bevy_wavelet_tex::bindings

#import bevy_wavelet_tex::decode::{WaveletTexture, sample}

// `MaterialUniform` in uniform.rs.
struct WaveletMaterial {
    base_color: WaveletTexture,
    normal: WaveletTexture,
    mask: WaveletTexture,
}

@group(#{MATERIAL_BIND_GROUP}) @binding(100) var<uniform> wavelet: WaveletMaterial;
@group(#{MATERIAL_BIND_GROUP}) @binding(101) var base_color_luma: texture_2d_array<f32>;
@group(#{MATERIAL_BIND_GROUP}) @binding(102) var base_color_chroma: texture_2d_array<f32>;
@group(#{MATERIAL_BIND_GROUP}) @binding(103) var normal_xy: texture_2d_array<f32>;
@group(#{MATERIAL_BIND_GROUP}) @binding(104) var mask_luma: texture_2d_array<f32>;

// What the base colour is multiplied by.
fn base_color_factor(uv: vec2<f32>, frag_coord: vec2<f32>, bias: f32) -> vec4<f32> {
    var factor = vec4(1.0);
#ifdef WAVELET_BASE_COLOR
    let color = sample(
        wavelet.base_color, base_color_luma, base_color_chroma, uv, frag_coord, bias,
    );
    factor = vec4(color, 1.0);
#endif
#ifdef WAVELET_MASK
    factor.a = sample(wavelet.mask, mask_luma, mask_luma, uv, frag_coord, bias).r;
#endif
    return factor;
}

#ifdef WAVELET_NORMAL
// The normal in tangent space, of unit length.
fn tangent_normal(uv: vec2<f32>, frag_coord: vec2<f32>, bias: f32) -> vec3<f32> {
    return normalize(sample(wavelet.normal, normal_xy, normal_xy, uv, frag_coord, bias));
}
#endif

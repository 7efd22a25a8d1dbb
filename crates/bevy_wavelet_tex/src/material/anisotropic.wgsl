// The anisotropic filter (thesis section 3.6.3): where a footprint is two pixels wide or more, the
// texture unit filters the means, which are then all that matters: details cancel out. Narrower
// footprints are averaged over decoded pixels, and in between the two are blended. This is the one
// filter that comes before linearising: data and normals are as good as supersampled, of sRGB textures
// strong contrasts come out a little dark. (To linearise the means of one round part of the footprint
// after the other does not help: a mean is that of encoded values already.)

#define_import_path bevy_wavelet_tex::anisotropic

#import bevy_wavelet_tex::decode::{
    assembled,
    from_decoded,
    has_chroma,
    has_next_mip,
    has_second_plane,
    is_decoded,
    load_chroma,
    load_mean,
}
#import bevy_wavelet_tex::sampling::{footprint_squared, sample, sample_bilinear}
#import bevy_wavelet_tex::types::{PACKING_BC1, WaveletTexture}

// Decoded samples along the longer axis, at most.
const MAX_TAPS = 16.0;

// A value in linear units. `coefficient_sampler` is anisotropic, linear, with mips, and has the
// address mode of the texture. Needs uniform control flow.
fn sample_anisotropic(
    texture: WaveletTexture,
    luma: texture_2d_array<f32>,
    detail: texture_2d_array<f32>,
    chroma: texture_2d_array<f32>,
    chroma_sampler: sampler,
    coefficient_sampler: sampler,
    uv: vec2<f32>,
    frag_coord: vec2<f32>,
    bias: f32,
) -> vec4<f32> {
    let ddx = dpdx(uv);
    let ddy = dpdy(uv);
    let axes = sqrt(footprint_squared(texture, ddx, ddy)) * exp2(bias);
    let taps = clamp(ceil(axes.x / max(axes.y, 1.0)), 1.0, MAX_TAPS);
    let width = max(axes.y, axes.x / MAX_TAPS);
    // A texture unit cannot repeat what ends within a block, nor interpolate chroma in wavelets.
    let fits = texture.whole != 0u
        && (has_next_mip(texture) || is_decoded(texture))
        && (!has_chroma(texture) || texture.chroma_packing == PACKING_BC1);
    if !fits {
        return sample(texture, luma, detail, chroma, chroma_sampler, uv, frag_coord, bias);
    }

    let size = vec2<f32>(texture.size);
    let x_is_longer = dot(ddx * size, ddx * size) >= dot(ddy * size, ddy * size);
    let long_axis = select(ddy, ddx, x_is_longer) * exp2(bias);
    let filtered = hardware_filtered(texture, luma, chroma, coefficient_sampler, uv, bias);
    if is_decoded(texture) {
        return filtered;
    }
    let share = saturate(log2(max(width, 1.0)));
    if share == 1.0 {
        return filtered;
    }

    // Level 0 along the longer axis; one sample where the texture is magnified.
    let count = select(taps, 1.0, axes.x <= 1.0);
    var sum = vec4(0.0);
    for (var i = 0.0; i < count; i += 1.0) {
        let place = uv + ((i + 0.5) / count - 0.5) * long_axis;
        sum += sample_bilinear(texture, luma, detail, chroma, chroma_sampler, place, 0u);
    }
    return mix(sum / count, filtered, share);
}

// The means as the texture unit filters them over the whole footprint. Its own level of detail fits:
// the means are half as many as the pixels. Needs uniform control flow.
fn hardware_filtered(
    texture: WaveletTexture,
    luma: texture_2d_array<f32>,
    chroma: texture_2d_array<f32>,
    coefficient_sampler: sampler,
    uv: vec2<f32>,
    bias: f32,
) -> vec4<f32> {
    let texel = textureSampleBias(luma, coefficient_sampler, uv, 0, bias);
    if is_decoded(texture) {
        return from_decoded(texture, texel);
    }
    let packing = texture.luma_packing;
    var means = vec2(load_mean(texture.planes[0], packing, texel), 0.0);
    if has_second_plane(texture) {
        let second = textureSampleBias(luma, coefficient_sampler, uv, 1, bias);
        means.y = load_mean(texture.planes[1], packing, second);
    }
    var co_cg = vec2(0.0);
    if has_chroma(texture) {
        co_cg = load_chroma(texture, textureSampleBias(chroma, coefficient_sampler, uv, 0, bias));
    }
    return assembled(texture, means, co_cg);
}

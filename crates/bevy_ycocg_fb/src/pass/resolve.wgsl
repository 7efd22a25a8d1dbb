// From the packed texture to colours, and to the display where Bevy has no pass for that.
//
// One pixel: its samples are resolved, its missing chrominance is reconstructed from its
// neighbours, and with YCOCG_FB_TONE_MAP it goes through Bevy's tone mapping, as in
// bevy_core_pipeline's `tonemapping.wgsl`.

#import bevy_core_pipeline::fullscreen_vertex_shader::FullscreenVertexOutput
#import bevy_render::{maths::powsafe, view::View}
#import bevy_ycocg_fb::{
    pack::{LARGEST_HALF, is_finite, stores_orange},
    reconstruct::{Neighborhood, decode, linear_from_srgb, missing_chroma},
}
#ifdef YCOCG_FB_TONE_MAP
#import bevy_core_pipeline::tonemapping::{screen_space_dither, tone_mapping}
#endif
#ifdef YCOCG_FB_UNORM8
#import bevy_ycocg_fb::pack::CHROMA_BIAS
#endif

#ifdef YCOCG_FB_SAMPLES
@group(0) @binding(0) var packed: texture_multisampled_2d<f32>;
#else
@group(0) @binding(0) var packed: texture_2d<f32>;
#endif
@group(0) @binding(1) var<uniform> view: View;

// Luminance and chrominance as stored, made safe: a pixel that overflowed is bright and gray, a
// NaN is black, and neither reaches its neighbours.
fn unbiased(texel: vec2<f32>) -> vec2<f32> {
#ifdef YCOCG_FB_UNORM8
    return texel - vec2(0.0, CHROMA_BIAS);
#else
    let overflown = select(0.0, LARGEST_HALF, texel.x > 0.0);
    let luminance = select(overflown, texel.x, is_finite(texel.x));
    // Too bright by additive blending: darker, of the same hue.
    let scale = LARGEST_HALF / max(luminance, LARGEST_HALF);
    return scale * vec2(max(luminance, 0.0), select(0.0, texel.y, is_finite(texel.y)));
#endif
}

// One pixel of the packed texture.
fn resolved(pixel: vec2<i32>) -> vec2<f32> {
#ifdef YCOCG_FB_SAMPLES
    var sum = vec2(0.0);
    var weights = 0.0;
    for (var i = 0; i < #{YCOCG_FB_SAMPLES}; i++) {
        let sample = unbiased(textureLoad(packed, pixel, i).xy);
#ifdef YCOCG_FB_TONE_MAP_WEIGHTED
        let weight = 1.0 / (1.0 + sample.x);
#else
        let weight = 1.0;
#endif
        sum += weight * sample;
        weights += weight;
    }
    return sum / weights;
#else
    return unbiased(textureLoad(packed, pixel, 0).xy);
#endif
}

// Mirrored at the borders of the viewport: a clamped neighbour would be of the wrong parity
// (thesis 4.5). Stays inside even where the viewport is one pixel wide.
fn mirrored(pixel: vec2<i32>, first: vec2<i32>, last: vec2<i32>) -> vec2<i32> {
    var p = select(pixel, 2 * first - pixel, pixel < first);
    p = select(p, 2 * last - p, p > last);
    return clamp(p, first, last);
}

@fragment
fn resolve(in: FullscreenVertexOutput) -> @location(0) vec4<f32> {
    let first = vec2<i32>(view.viewport.xy);
    let last = first + vec2<i32>(view.viewport.zw) - 1;
    // Fragments beyond the border exist where a quad reaches over it.
    let pixel = mirrored(vec2<i32>(in.position.xy), first, last);
    let center = resolved(pixel);

    var n: Neighborhood;
    n.center = center;
    // A row or column alone has neighbours in one direction, a single pixel has none.
    n.exists = vec4<f32>(vec4(last.xx, last.yy) > vec4(first.xx, first.yy));
#ifdef YCOCG_FB_QUAD
    // The differences within the quad lead to the neighbours (thesis 4.5, optimisations).
    let side = vec2<f32>(1 - 2 * (vec2<i32>(in.position.xy) & vec2(1)));
    let right = center + side.x * dpdxFine(center);
    let below = center + side.y * dpdyFine(center);
    n.exists *= vec4(1.0, 0.0, 1.0, 0.0);
    n.luminance = vec4(right.xx, below.xx);
    n.chrominance = vec4(right.yy, below.yy);
#else
    let right = resolved(mirrored(pixel + vec2(1, 0), first, last));
    let below = resolved(mirrored(pixel + vec2(0, 1), first, last));
#ifdef YCOCG_FB_NEAREST
    n.luminance = vec4(right.xx, below.xx);
    n.chrominance = vec4(right.yy, below.yy);
#else
    let left = resolved(mirrored(pixel - vec2(1, 0), first, last));
    let above = resolved(mirrored(pixel - vec2(0, 1), first, last));
    n.luminance = vec4(right.x, left.x, below.x, above.x);
    n.chrominance = vec4(right.y, left.y, below.y, above.y);
#endif
#ifdef YCOCG_FB_WIDE
    let lower_right = resolved(mirrored(pixel + vec2(1, 1), first, last));
    let upper_right = resolved(mirrored(pixel + vec2(1, -1), first, last));
    let lower_left = resolved(mirrored(pixel + vec2(-1, 1), first, last));
    let upper_left = resolved(mirrored(pixel + vec2(-1, -1), first, last));
    n.diagonal_luminance = vec4(lower_right.x, upper_right.x, lower_left.x, upper_left.x);
    n.diagonal_chrominance = vec4(lower_right.y, upper_right.y, lower_left.y, upper_left.y);
#endif
#endif

    var rgb = decode(center, missing_chroma(n), stores_orange(pixel));
#ifdef YCOCG_FB_UNORM8
    rgb = linear_from_srgb(rgb);
#endif
#ifdef YCOCG_FB_TONE_MAP
    rgb = tone_mapping(vec4(rgb, 1.0), view.color_grading).rgb;
#ifdef DEBAND_DITHER
    rgb = powsafe(rgb, 1.0 / 2.2) + screen_space_dither(in.position.xy);
    rgb = powsafe(rgb, 2.2);
#endif
#endif
    return vec4(rgb, 1.0);
}

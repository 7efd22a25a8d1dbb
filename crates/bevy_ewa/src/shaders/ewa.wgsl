// Elliptical texture filtering for any shader. As `reference::sample`.
//
//     #import bevy_ewa::{ewa_sample, ewa_sample_grad}
//     #import bevy_ewa::types::EwaSettings
//
//     @group(#{MATERIAL_BIND_GROUP}) @binding(2) var<uniform> ewa: EwaSettings;
//     ...
//     let color = ewa_sample(texture, texture_sampler, uv, ewa);
//
// The sampler filters linearly, between mip levels too; its address modes are respected.
#define_import_path bevy_ewa

#import bevy_ewa::exact::exact
#import bevy_ewa::footprint::footprint
#import bevy_ewa::probes::{approximate, single, software_anisotropic, ALL, EVEN, ODD}
#import bevy_ewa::types::{
    EwaFootprint,
    EwaSettings,
    METHOD_APPROXIMATE,
    METHOD_BILINEAR,
    METHOD_HARDWARE,
    METHOD_SOFTWARE_ANISOTROPIC,
    METHOD_SPATIAL,
    METHOD_SPATIAL_TEMPORAL,
    METHOD_TEMPORAL,
}

// Texture coordinates below which 32-bit floats are precise enough as they are.
const PRECISE_UV: f32 = 16.0;

// Filters a texture in a fragment shader. Call it where `textureSample` may be called: it takes
// derivatives.
fn ewa_sample(
    tex: texture_2d<f32>,
    samp: sampler,
    uv: vec2<f32>,
    settings: EwaSettings,
) -> vec4<f32> {
    return ewa_sample_grad(tex, samp, uv, dpdx(uv), dpdy(uv), settings);
}

// Filters a texture with given derivatives, anywhere.
fn ewa_sample_grad(
    tex: texture_2d<f32>,
    samp: sampler,
    uv: vec2<f32>,
    ddx: vec2<f32>,
    ddy: vec2<f32>,
    settings: EwaSettings,
) -> vec4<f32> {
    let size = vec2<f32>(textureDimensions(tex, 0));
    let f = footprint(vec4(ddx, ddy), size, settings.max_anisotropy);
    return ewa_sample_footprint(tex, samp, uv, vec4(ddx, ddy), f, settings);
}

// Filters a texture whose footprint is known already.
fn ewa_sample_footprint(
    tex: texture_2d<f32>,
    samp: sampler,
    uv: vec2<f32>,
    gradient: vec4<f32>,
    f: EwaFootprint,
    settings: EwaSettings,
) -> vec4<f32> {
    let at = reduced(uv, settings.periodic == 1u);
    if settings.method == METHOD_HARDWARE {
        return textureSampleGrad(tex, samp, at, gradient.xy, gradient.zw);
    }
    if settings.method <= METHOD_BILINEAR {
        return exact(tex, samp, f, at, settings);
    }
    if settings.method == METHOD_SOFTWARE_ANISOTROPIC {
        return software_anisotropic(tex, samp, at, gradient.xy, gradient.zw);
    }
    var turn = ALL;
    if settings.method == METHOD_TEMPORAL || settings.method == METHOD_SPATIAL_TEMPORAL {
        turn = select(ODD, EVEN, settings.frame % 2u == 0u);
    }
    var part = 1.0;
    if settings.method == METHOD_SPATIAL || settings.method == METHOD_SPATIAL_TEMPORAL {
        part = saturate(f.anisotropy - settings.spatial_threshold + 1.0);
    }
    var color = vec4(0.0);
    if part < 1.0 {
        color = single(tex, samp, f, at, settings) * (1.0 - part);
    }
    if part > 0.0 {
        color += approximate(tex, samp, f, at, settings, turn) * part;
    }
    return color;
}

// Texture coordinates less whole periods, two textures wide so that they are right for textures
// that mirror too; 0 for what is not finite.
fn reduced(uv: vec2<f32>, periodic: bool) -> vec2<f32> {
    let finite = (bitcast<vec2<u32>>(uv) & vec2(0x7f800000u)) != vec2(0x7f800000u);
    let at = select(vec2(0.0), uv, finite);
    if periodic {
        return select(at, at - 2.0 * floor(at * 0.5), abs(at) > vec2(PRECISE_UV));
    }
    return clamp(at, vec2(-1e6), vec2(1e6));
}

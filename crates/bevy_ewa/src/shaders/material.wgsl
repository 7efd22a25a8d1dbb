// What Bevy's own shaders call under BEVY_EWA in place of textureSampleBias. The settings are
// shader defs: constants, of which the driver keeps the one method that is used.
#define_import_path bevy_ewa::material

#import bevy_ewa::ewa_sample_footprint
#import bevy_ewa::footprint::footprint
#import bevy_ewa::types::{EwaFootprint, EwaSettings}
#import bevy_pbr::mesh_view_bindings::view

// The footprint of the last map: those of the same size and UV set share it.
var<private> last_gradient: vec4<f32>;
var<private> last_size: vec2<f32>;
var<private> last_footprint: EwaFootprint;

// `gradient` is dpdx of the texture coordinates and dpdy, without the bias.
fn sample_map(
    gradient: vec4<f32>,
    tex: texture_2d<f32>,
    samp: sampler,
    uv: vec2<f32>,
    mip_bias: f32,
) -> vec4<f32> {
    let settings = EwaSettings(
        #{EWA_METHOD}u,
        #{EWA_PROBES}u,
        #{EWA_KERNEL}u,
        #{EWA_LEVEL_OF_DETAIL}u,
        bitcast<f32>(#{EWA_KERNEL_RADIUS_PIXELS}u),
        bitcast<f32>(#{EWA_PROBE_RADIUS_PIXELS}u),
        bitcast<f32>(#{EWA_MAX_ANISOTROPY}u),
        bitcast<f32>(#{EWA_MINOR_RADIUS_TEXELS}u),
        bitcast<f32>(#{EWA_LEVEL_BLEND}u),
        bitcast<f32>(#{EWA_MAX_FETCHES}u),
        bitcast<f32>(#{EWA_SPATIAL_THRESHOLD}u),
        #{EWA_SAMPLER_ANISOTROPY}u,
        #{EWA_PERIODIC}u,
        view.frame_count,
        #{EWA_UNIFORM_LEVELS}u,
        0u,
    );
    let biased = gradient * exp2(mip_bias);
    let size = vec2<f32>(textureDimensions(tex, 0));
    if any(biased != last_gradient) || any(size != last_size) {
        last_footprint = footprint(biased, size, settings.max_anisotropy);
        last_gradient = biased;
        last_size = size;
    }
    return ewa_sample_footprint(tex, samp, uv, biased, last_footprint, settings);
}

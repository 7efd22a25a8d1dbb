// Filters a texture at coordinates and derivatives that are given for each pixel.

#import bevy_ewa::ewa_sample_grad
#import bevy_ewa::types::EwaSettings
#import bevy_pbr::forward_io::VertexOutput
#import bevy_pbr::mesh_view_bindings::view

@group(#{MATERIAL_BIND_GROUP}) @binding(0) var<uniform> settings: EwaSettings;
@group(#{MATERIAL_BIND_GROUP}) @binding(1) var filtered: texture_2d<f32>;
@group(#{MATERIAL_BIND_GROUP}) @binding(2) var filtered_sampler: sampler;
@group(#{MATERIAL_BIND_GROUP}) @binding(3) var gradients: texture_2d<f32>;
@group(#{MATERIAL_BIND_GROUP}) @binding(4) var coordinates: texture_2d<f32>;

@fragment
fn fragment(in: VertexOutput) -> @location(0) vec4<f32> {
    let pixel = vec2<i32>(in.position.xy);
    let gradient = textureLoad(gradients, pixel, 0);
    let uv = textureLoad(coordinates, pixel, 0).xy;
    // Constants, as a material's pipeline would have them: the driver keeps one method.
    let constant = EwaSettings(
        #{EWA_METHOD}u,
        #{EWA_PROBES}u,
        #{EWA_KERNEL}u,
        settings.level_of_detail,
        settings.kernel_radius_pixels,
        settings.probe_radius_pixels,
        settings.max_anisotropy,
        settings.minor_radius_texels,
        settings.level_blend,
        settings.max_fetches,
        settings.spatial_threshold,
        #{EWA_SAMPLER_ANISOTROPY}u,
        settings.periodic,
        settings.frame,
        #{EWA_UNIFORM_LEVELS}u,
        0u,
    );
    return ewa_sample_grad(filtered, filtered_sampler, uv, gradient.xy, gradient.zw, constant);
}

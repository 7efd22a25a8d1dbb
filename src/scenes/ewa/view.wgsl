// Shows how a surface is filtered: the ellipse of every 16th pixel in its texture, or in red where
// the anisotropy exceeds the threshold (thesis figure 5.8).

#import bevy_ewa::footprint::footprint
#import bevy_ewa::types::EwaSettings
#import bevy_pbr::forward_io::VertexOutput

@group(#{MATERIAL_BIND_GROUP}) @binding(0) var<uniform> settings: EwaSettings;
@group(#{MATERIAL_BIND_GROUP}) @binding(1) var<uniform> view: vec4<f32>;
@group(#{MATERIAL_BIND_GROUP}) @binding(2) var color_texture: texture_2d<f32>;
@group(#{MATERIAL_BIND_GROUP}) @binding(3) var color_sampler: sampler;

const TILE_PIXELS: f32 = 16.0;

@fragment
fn fragment(in: VertexOutput) -> @location(0) vec4<f32> {
    let gradient = vec4(dpdx(in.uv), dpdy(in.uv));
    let size = vec2<f32>(textureDimensions(color_texture));
    let f = footprint(gradient, size, settings.max_anisotropy);
    let color = textureSample(color_texture, color_sampler, in.uv).rgb;
    let gray = vec3(dot(color, vec3(0.2126, 0.7152, 0.0722)));
    // Blend over the last unit, as the method does.
    let over = saturate(f.anisotropy - settings.spatial_threshold + 1.0);
    let tinted = mix(color, gray * vec3(0.7, 0.05, 0.05) + vec3(0.3, 0.0, 0.0), over);
    if view.x > 0.5 {
        return vec4(tinted, 1.0);
    }
    // The position in the tile stands for texels, u to the right and v down, such that the major
    // axis fits.
    let at = (fract(in.position.xy / TILE_PIXELS) - 0.5) * 2.2;
    let along = dot(at, f.major_direction);
    let across = dot(at, vec2(-f.major_direction.y, f.major_direction.x));
    let aspect = f.major_radius_texels / max(f.minor_radius_texels, 1e-12);
    // The minor axis is at least a pixel wide, to be seen.
    let width = max(1.0 / aspect, 1.1 / TILE_PIXELS);
    let inside = along * along + across * across / (width * width) < 1.0;
    let ellipse = mix(vec3(1.0, 0.85, 0.2), vec3(0.9, 0.1, 0.05), over);
    return vec4(select(gray * 0.35, ellipse, inside), 1.0);
}

// The accumulated light on the surface.

#import bevy_core_pipeline::fullscreen_vertex_shader::FullscreenVertexOutput
#import bevy_frugal_lab::deferred_accumulation::surface::{surface_at, view}
#import bevy_frugal_lab::deferred_accumulation::packing::{luminance, unpack}
#import bevy_ycocg_fb::pack::stores_orange

// Diffuse and specular light as the lamps left them.
@group(0) @binding(1) var accumulated: texture_2d<f32>;
#ifdef EXACT
@group(0) @binding(2) var accumulated_specular: texture_2d<f32>;
#endif

#ifdef PACKED
// The pixel at an offset of one, mirrored at the border of the viewport so that it stores the
// chrominance that the centre lacks.
fn neighbour(pixel: vec2<i32>, offset: vec2<i32>) -> vec4<f32> {
    let low = vec2<i32>(view.viewport.xy);
    let high = low + vec2<i32>(view.viewport.zw) - 1;
    let there = pixel + offset;
    let is_inside = all(there >= low) && all(there <= high);
    return textureLoad(accumulated, select(pixel - offset, there, is_inside), 0);
}
#endif

@fragment
fn fragment(in: FullscreenVertexOutput) -> @location(0) vec4<f32> {
    let pixel = vec2<i32>(in.position.xy);
    let stored = textureLoad(accumulated, pixel, 0);
#ifdef EXACT
    let diffuse = stored.rgb;
    let specular = textureLoad(accumulated_specular, pixel, 0).rgb;
#else ifdef PACKED
    let right = neighbour(pixel, vec2(1, 0));
    let left = neighbour(pixel, vec2(-1, 0));
    let below = neighbour(pixel, vec2(0, 1));
    let above = neighbour(pixel, vec2(0, -1));
    let is_orange = stores_orange(pixel);
    let diffuse = unpack(stored.xy, array(right.xy, left.xy, below.xy, above.xy), is_orange);
    let specular = unpack(stored.zw, array(right.zw, left.zw, below.zw, above.zw), is_orange);
#else
    let diffuse = stored.rgb;
    // The colour of the diffuse light has to do for the highlights.
    let specular = stored.a * diffuse / max(luminance(diffuse), 1e-6);
#endif
    let surface = surface_at(in.position.xy);
    let color = surface.albedo * diffuse + specular;
    return vec4(select(vec3(0.0), color, surface.exists), 1.0);
}

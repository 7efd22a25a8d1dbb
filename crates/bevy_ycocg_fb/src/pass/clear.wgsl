// The packed clear colour: only where it has chrominance, which depends on the pixel.

#import bevy_ycocg_fb::pack::pack_fragment

// Scene-linear.
@group(0) @binding(0) var<uniform> clear_color: vec4<f32>;

@fragment
fn clear(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    return pack_fragment(clear_color, position);
}

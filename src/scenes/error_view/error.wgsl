// The difference of two pictures in the colours of `metrics::heat_map`.

#import bevy_sprite::mesh2d_vertex_output::VertexOutput

@group(#{MATERIAL_BIND_GROUP}) @binding(0) var before: texture_2d<f32>;
@group(#{MATERIAL_BIND_GROUP}) @binding(1) var after: texture_2d<f32>;
@group(#{MATERIAL_BIND_GROUP}) @binding(2) var<uniform> gain: f32;

fn srgb_from_linear(color: vec3<f32>) -> vec3<f32> {
    let curve = 1.055 * pow(color, vec3(1.0 / 2.4)) - 0.055;
    return select(curve, 12.92 * color, color <= vec3(0.0031308));
}

fn linear_from_srgb(color: vec3<f32>) -> vec3<f32> {
    let curve = pow((color + 0.055) / 1.055, vec3(2.4));
    return select(curve, color / 12.92, color <= vec3(0.04045));
}

// The fit of `heat_map::magma`, in sRGB.
fn magma(value: f32) -> vec3<f32> {
    let t = saturate(value);
    var sum = vec3(18.655705, -11.489774, -5.6019615);
    sum = sum * t + vec3(-50.768525, 29.046583, 4.234153);
    sum = sum * t + vec3(52.17614, -27.943606, 12.944169);
    sum = sum * t + vec3(-27.668733, 14.264731, -13.649213);
    sum = sum * t + vec3(8.353717, -3.5777195, 0.3144679);
    sum = sum * t + vec3(0.25166054, 0.67752324, 2.4940266);
    sum = sum * t + vec3(-0.002136485, -0.000749655, -0.005386128);
    return saturate(sum);
}

@fragment
fn fragment(in: VertexOutput) -> @location(0) vec4<f32> {
    let size = textureDimensions(before);
    let pixel = min(vec2<u32>(in.uv * vec2<f32>(size)), size - 1u);
    // In whole levels: how a texture in sRGB is decoded is up to the driver.
    let a = round(255.0 * srgb_from_linear(textureLoad(before, pixel, 0).rgb));
    let b = round(255.0 * srgb_from_linear(textureLoad(after, pixel, 0).rgb));
    let difference = abs(a - b) / 255.0;
    let largest = max(max(difference.r, difference.g), difference.b);
    return vec4(linear_from_srgb(magma(largest * gain)), 1.0);
}

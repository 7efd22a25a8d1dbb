// One lamp, over the whole screen: its diffuse and its specular light, added to what is there.

#import bevy_frugal_lab::deferred_accumulation::surface::surface_at
#import bevy_frugal_lab::deferred_accumulation::packing::{luminance, pack}

struct Lamp {
    // In metres.
    position: vec3<f32>,
    // Radiance times square metres, scene-linear.
    intensity: vec3<f32>,
}

@group(0) @binding(1) var<uniform> lamps: array<Lamp, #{MAX_LAMPS}>;

// Exponent and strength of the Blinn-Phong highlight.
const SHININESS: f32 = 60.0;
const SPECULAR: f32 = 3.0;

struct Vertex {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat) lamp: u32,
}

// A triangle that covers the screen; the instance is the lamp.
@vertex
fn vertex(@builtin(vertex_index) index: u32, @builtin(instance_index) lamp: u32) -> Vertex {
    let corner = vec2(f32(index & 1u), f32(index >> 1u)) * 4.0 - 1.0;
    return Vertex(vec4(corner, 0.0, 1.0), lamp);
}

struct Light {
    diffuse: vec3<f32>,
    specular: vec3<f32>,
}

fn light_at(position: vec2<f32>, lamp: Lamp) -> Light {
    let surface = surface_at(position);
    var light = Light(vec3(0.0), vec3(0.0));
    if !surface.exists {
        return light;
    }
    let to_lamp = lamp.position - surface.position;
    let direction = normalize(to_lamp);
    let cosine = max(dot(surface.normal, direction), 0.0);
    let halfway = normalize(direction + surface.to_eye);
    let highlight = pow(max(dot(surface.normal, halfway), 0.0), SHININESS);
    let received = lamp.intensity / dot(to_lamp, to_lamp);
    light.diffuse = cosine * received;
    light.specular = select(0.0, SPECULAR * highlight, cosine > 0.0) * received;
    return light;
}

#ifdef EXACT
struct Targets {
    @location(0) diffuse: vec4<f32>,
    @location(1) specular: vec4<f32>,
}

@fragment
fn fragment(in: Vertex) -> Targets {
    let light = light_at(in.position.xy, lamps[in.lamp]);
    return Targets(vec4(light.diffuse, 0.0), vec4(light.specular, 0.0));
}
#else
@fragment
fn fragment(in: Vertex) -> @location(0) vec4<f32> {
    let light = light_at(in.position.xy, lamps[in.lamp]);
#ifdef PACKED
    let pixel = vec2<i32>(in.position.xy);
    return vec4(pack(light.diffuse, pixel), pack(light.specular, pixel));
#else
    return vec4(light.diffuse, luminance(light.specular));
#endif
}
#endif

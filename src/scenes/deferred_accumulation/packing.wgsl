// Light in two channels, by the library of bevy_ycocg_fb.
#define_import_path bevy_frugal_lab::deferred_accumulation::packing

#import bevy_ycocg_fb::pack::{LARGEST_HALF, channels, sanitized_rgb, ycocg_from_rgb}
#import bevy_ycocg_fb::reconstruct::{Neighborhood, decode, guided}

fn luminance(color: vec3<f32>) -> f32 {
    return ycocg_from_rgb(color).x;
}

fn pack(color: vec3<f32>, pixel: vec2<i32>) -> vec2<f32> {
    return channels(sanitized_rgb(color, LARGEST_HALF), vec2<f32>(pixel));
}

// The colour of a packed pixel. Neighbours: to the right, to the left, below and above.
fn unpack(center: vec2<f32>, neighbors: array<vec2<f32>, 4>, stores_orange: bool) -> vec3<f32> {
    let right = neighbors[0];
    let left = neighbors[1];
    let below = neighbors[2];
    let above = neighbors[3];
    var n: Neighborhood;
    n.center = center;
    n.luminance = vec4(right.x, left.x, below.x, above.x);
    n.chrominance = vec4(right.y, left.y, below.y, above.y);
    n.exists = vec4(1.0);
    return decode(center, guided(n), stores_orange);
}

// The missing chrominance of a pixel, from its neighbours (thesis 4.5). The same as
// `reference::reconstruct`, which says why.

#define_import_path bevy_ycocg_fb::reconstruct

#import bevy_ycocg_fb::pack::rgb_from_ycocg

// (luminance, chrominance) of a pixel and of its four neighbours, which store the other
// chrominance.
struct Neighborhood {
    center: vec2<f32>,
    right: vec2<f32>,
    left: vec2<f32>,
    below: vec2<f32>,
    above: vec2<f32>,
    // Whether there is any neighbour horizontally, vertically.
    exists: vec2<bool>,
}

fn linear_from_srgb(srgb: vec3<f32>) -> vec3<f32> {
    let low = srgb / 12.92;
    let high = pow((srgb + 0.055) / 1.055, vec3(2.4));
    return select(high, low, srgb <= vec3(0.04045));
}

// RGB without negative components: chrominance is brought into the range that this luminance
// admits, |Cg| <= Y and |Co| <= Y - Cg.
fn nonnegative(ycocg: vec3<f32>) -> vec3<f32> {
    let green = clamp(ycocg.z, -ycocg.x, ycocg.x);
    let rest = ycocg.x - green;
    let orange = clamp(ycocg.y, -rest, rest);
    return vec3(rest + orange, ycocg.x + green, rest - orange);
}

// 1 for the neighbours (right, left, below, above) that exist.
fn existing(n: Neighborhood) -> vec4<f32> {
    return vec4(vec2(f32(n.exists.x)), vec2(f32(n.exists.y)));
}

fn luminances(n: Neighborhood) -> vec4<f32> {
    return vec4(n.right.x, n.left.x, n.below.x, n.above.x);
}

fn chromas(n: Neighborhood) -> vec4<f32> {
    return vec4(n.right.y, n.left.y, n.below.y, n.above.y);
}

fn missing_chroma(n: Neighborhood) -> f32 {
#ifdef YCOCG_FB_NEAREST
    return nearest(n);
#endif
#ifdef YCOCG_FB_BILINEAR
    return bilinear(n);
#endif
#ifdef YCOCG_FB_EDGE_DIRECTED
    return edge_directed(n);
#endif
#ifdef YCOCG_FB_GUIDED
    return guided(n);
#endif
#ifdef YCOCG_FB_QUAD
    return guided(n);
#endif
}

fn nearest(n: Neighborhood) -> f32 {
    return select(select(0.0, n.below.y, n.exists.y), n.right.y, n.exists.x);
}

fn bilinear(n: Neighborhood) -> f32 {
    let weights = existing(n);
    return dot(weights, chromas(n)) / max(dot(weights, vec4(1.0)), 1.0);
}

// Thesis, listing 4.2, including its choice of the first neighbour where none is similar.
fn edge_directed(n: Neighborhood) -> f32 {
    let threshold = 30.0 / 255.0;
    var weights = existing(n) * (1.0 - step(vec4(threshold), abs(luminances(n) - n.center.x)));
    let sum = dot(weights, vec4(1.0));
    return select(dot(weights, chromas(n)) / max(sum, 1.0), nearest(n), sum == 0.0);
}

fn guided(n: Neighborhood) -> f32 {
    let y = luminances(n);
    let ratio = chromas(n) / max(y, vec4(1e-7));
    let d = (y - n.center.x) / (max(y, vec4(n.center.x)) + 1e-7);
    var weights = existing(n) / (d * d + 1e-3);
    let sum = dot(weights, vec4(1.0));
    return select(0.0, n.center.x * dot(weights, ratio) / sum, sum > 0.0);
}

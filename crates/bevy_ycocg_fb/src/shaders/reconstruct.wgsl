// The missing chrominance of a pixel, from its neighbours (thesis 4.5): `reference::reconstruct`
// in WGSL, where the formulas are explained.

#define_import_path bevy_ycocg_fb::reconstruct

#import bevy_ycocg_fb::pack::{LARGEST_HALF, rgb_from_ycocg}

// Luminance difference from which on the thesis's filter sees an edge (thesis 4.5).
const EDGE_THRESHOLD: f32 = 30.0 / 255.0;
// Luminance below which ratios are not trusted.
const FLOOR: f32 = 1.0 / 1048576.0;
// Relative difference of luminance that is always tolerated.
const TOLERANCE: f32 = 0.02;
// How much is tolerated beyond the most similar neighbour's difference.
const TOLERANCE_GROWTH: f32 = 4.0;
// Change of the chrominance ratio at which a weight has fallen to a quarter.
const CHROMINANCE_SCALE: f32 = 0.2;
// More than any difference of luminance.
const FAR: f32 = 1e30;

// (luminance, chrominance) of a pixel and of its neighbours. Those beside it store the chrominance
// that it lacks, the diagonal ones the same as itself.
struct Neighborhood {
    center: vec2<f32>,
    // To the right, to the left, below and above.
    luminance: vec4<f32>,
    chrominance: vec4<f32>,
    // 1 for those that exist: a viewport one pixel wide has none to the right and left.
    exists: vec4<f32>,
#ifdef YCOCG_FB_WIDE
    // To the lower right, upper right, lower left and upper left.
    diagonal_luminance: vec4<f32>,
    diagonal_chrominance: vec4<f32>,
#endif
}

fn linear_from_srgb(srgb: vec3<f32>) -> vec3<f32> {
    let low = srgb / 12.92;
    let high = pow((srgb + 0.055) / 1.055, vec3(2.4));
    return select(high, low, srgb <= vec3(0.04045));
}

// The colour of a packed pixel and its missing chrominance. No channel is negative
// or too large: the missing
// chrominance is brought into the range that the other two admit.
fn decode(center: vec2<f32>, missing: f32, stores_orange: bool) -> vec3<f32> {
    let y = center.x;
    let stored = center.y;
    let green = max(min(missing, y - abs(stored)), -y);
    let orange = max(min(missing, y - stored), stored - y);
    let ycocg = select(vec3(y, orange, stored), vec3(y, stored, green), stores_orange);
    return clamp(rgb_from_ycocg(ycocg), vec3(0.0), vec3(LARGEST_HALF));
}

fn missing_chroma(n: Neighborhood) -> f32 {
#ifdef YCOCG_FB_NEAREST
    return nearest(n);
#else ifdef YCOCG_FB_BILINEAR
    return weighted_mean(n.exists, n.chrominance);
#else ifdef YCOCG_FB_EDGE_DIRECTED
    return edge_directed(n);
#else
    return guided(n);
#endif
}

// That of the neighbour to the right; of the one below where there is none.
fn nearest(n: Neighborhood) -> f32 {
    return select(n.exists.z * n.chrominance.z, n.chrominance.x, n.exists.x > 0.0);
}

// Thesis, listing 4.2, which takes the first neighbour where none is similar.
fn edge_directed(n: Neighborhood) -> f32 {
    let differences = abs(n.luminance - n.center.x);
    let weights = n.exists * vec4<f32>(differences < vec4(EDGE_THRESHOLD));
    return select(weighted_mean(weights, n.chrominance), nearest(n), all(weights == vec4(0.0)));
}

// Chrominance relative to luminance, from neighbours of similar luminance: `guided`, `wide` and
// `in_quad` of the reference.
fn guided(n: Neighborhood) -> f32 {
    let ratios = ratio(n.luminance, n.chrominance);
    let smaller = max(min(n.luminance, vec4(n.center.x)), vec4(FLOOR));
    let differences = abs(n.luminance - n.center.x) / smaller;
    let candidates = select(vec4(FAR), differences, n.exists > vec4(0.0));
    let pairs = min(candidates.xy, candidates.zw);
    let tolerance = TOLERANCE + TOLERANCE_GROWTH * min(pairs.x, pairs.y);
    var roots = 1.0 / (tolerance + differences);
#ifndef YCOCG_FB_QUAD
    // Along the axis on which the chrominance changes less.
    let changes = abs(ratios.xz - ratios.yw);
    roots /= CHROMINANCE_SCALE + changes.xxyy;
#endif
#ifdef YCOCG_FB_WIDE
    // Away from edges of the other chrominance. Without diagonal neighbours there are none.
    let own = ratio(vec4(n.center.x), vec4(n.center.y));
    let diagonals = ratio(n.diagonal_luminance, n.diagonal_chrominance);
    let means = 0.5 * (diagonals.xzxy + diagonals.ywzw);
    let other_changes = abs(means - own) * min(n.exists.x, n.exists.z);
    roots /= CHROMINANCE_SCALE + other_changes;
#endif
    return n.center.x * weighted_mean(n.exists * roots * roots, ratios);
}

// Chrominance relative to luminance: Co from -2 to 2, Cg from -1 to 1.
fn ratio(luminance: vec4<f32>, chrominance: vec4<f32>) -> vec4<f32> {
    return clamp(chrominance / max(luminance, vec4(FLOOR)), vec4(-2.0), vec4(2.0));
}

// 0 where there are no weights.
fn weighted_mean(weights: vec4<f32>, values: vec4<f32>) -> f32 {
    let sum = dot(weights, vec4(1.0));
    return select(dot(weights, values) / sum, 0.0, sum <= 0.0);
}

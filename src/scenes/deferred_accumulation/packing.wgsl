// Two channels instead of three: luminance, and one chrominance in a checkerboard. The same as
// bevy_ycocg_fb::reference.
#define_import_path bevy_frugal_lab::deferred_accumulation::packing

const F16_MAX: f32 = 65504.0;
const LUMINANCE_FLOOR: f32 = 1.0 / 1048576.0;
const TOLERANCE: f32 = 0.02;
const TOLERANCE_GROWTH: f32 = 4.0;
const CHROMINANCE_SCALE: f32 = 0.2;

fn luminance(color: vec3<f32>) -> f32 {
    return dot(color, vec3(0.25, 0.5, 0.25));
}

fn stores_co(pixel: vec2<i32>) -> bool {
    return ((pixel.x ^ pixel.y) & 1) == 0;
}

fn pack(color: vec3<f32>, pixel: vec2<i32>) -> vec2<f32> {
    let rgb = clamp(color, vec3(0.0), vec3(F16_MAX));
    let co = 0.5 * (rgb.r - rgb.b);
    let cg = 0.5 * rgb.g - 0.25 * (rgb.r + rgb.b);
    return vec2(luminance(rgb), select(cg, co, stores_co(pixel)));
}

fn ratio(pixel: vec2<f32>) -> f32 {
    return clamp(pixel.y / max(pixel.x, LUMINANCE_FLOOR), -2.0, 2.0);
}

// The colour of a packed pixel. Neighbours: to the right, to the left, below and above.
fn unpack(
    center: vec2<f32>,
    neighbours: array<vec2<f32>, 4>,
    center_stores_co: bool,
) -> vec3<f32> {
    let right = neighbours[0];
    let left = neighbours[1];
    let below = neighbours[2];
    let above = neighbours[3];
    let luminances = vec4(right.x, left.x, below.x, above.x);
    let ratios = vec4(ratio(right), ratio(left), ratio(below), ratio(above));

    let darker = max(min(luminances, vec4(center.x)), vec4(LUMINANCE_FLOOR));
    let differences = abs(luminances - center.x) / darker;
    let smallest = min(min(differences.x, differences.y), min(differences.z, differences.w));
    let tolerance = TOLERANCE + TOLERANCE_GROWTH * smallest;
    let changes = abs(ratios.xz - ratios.yw).xxyy;
    let roots = 1.0 / ((tolerance + differences) * (CHROMINANCE_SCALE + changes));
    let weights = roots * roots;
    let missing = center.x * dot(weights, ratios) / dot(weights, vec4(1.0));

    // The missing chrominance is kept where no channel is negative.
    let y = center.x;
    var co = center.y;
    var cg = max(min(missing, y - abs(co)), -y);
    if !center_stores_co {
        cg = center.y;
        co = max(min(missing, y - cg), cg - y);
    }
    return max(vec3(y + co - cg, y + cg, y - co - cg), vec3(0.0));
}

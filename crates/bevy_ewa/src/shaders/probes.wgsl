// A few anisotropic fetches in the place of an ellipse (thesis 5.5). As `reference::probes`, where
// the constants are explained.
#define_import_path bevy_ewa::probes

#import bevy_ewa::footprint::is_finite
#import bevy_ewa::types::{EwaFootprint, EwaSettings}

const MOST_TAPS: f32 = 16.0;
const TIE: f32 = 1e-3;
const KERNEL_VARIANCE: f32 = 0.1361;
const PROFILE_VARIANCE: f32 = 0.14285714;
const PROFILE_INTEGRAL: f32 = 1.06666667;
const PROBE_WIDTH: f32 = 1.2;
const SINGLE_LENGTH: f32 = 1.25;

// Which probes are taken.
const ALL: u32 = 0u;
const EVEN: u32 = 1u;
const ODD: u32 = 2u;

fn probe_count(probes: u32, anisotropy: f32) -> u32 {
    if probes == 0u {
        return 2u * u32(clamp(ceil(anisotropy / 8.0 - TIE), 1.0, 7.0)) + 1u;
    }
    return probes;
}

// Probes on the major axis with the weights of the kernel (equations 5.5 and 5.6).
fn approximate(
    tex: texture_2d<f32>,
    samp: sampler,
    f: EwaFootprint,
    uv: vec2<f32>,
    settings: EwaSettings,
    turn: u32,
) -> vec4<f32> {
    let aspect = f.major_radius_texels / max(f.minor_radius_texels, 1e-12);
    let places = probe_count(settings.probes, aspect) / 2u;
    let count = f32(2u * places + 1u);
    let major = settings.probe_radius_pixels * f.major_radius_texels;
    let minor = settings.probe_radius_pixels * f.minor_radius_texels;
    let line = sqrt(max(major - minor, 0.0)) * sqrt(major + minor);
    let spread = PROFILE_VARIANCE + 2.0 / 3.0 / (count * count);
    let spacing = 2.0 * line / count * sqrt(KERNEL_VARIANCE / spread);
    let width = PROBE_WIDTH * minor;
    let size = vec2<f32>(textureDimensions(tex, 0));
    let across = vec2(-f.major_direction.y, f.major_direction.x) * width / size;
    let along = f.major_direction * max(spacing, width) / size;
    let step = f.major_direction * spacing / size;

    var sum = vec4(0.0);
    var total = 0.0;
    for (var place = 1u; place <= places; place += 1u) {
        if (turn == EVEN && place % 2u == 1u) || (turn == ODD && place % 2u == 0u) {
            continue;
        }
        let n = f32(place);
        let weight = profile((2.0 * n + 1.0) / count) - profile((2.0 * n - 1.0) / count);
        sum += weight * probe(tex, samp, uv + n * step, along, across, settings);
        sum += weight * probe(tex, samp, uv - n * step, along, across, settings);
        total += 2.0 * weight;
    }
    // Of two frames each has half of all weight, so that their mean is the picture of all probes.
    let share = select(PROFILE_INTEGRAL * 0.5, PROFILE_INTEGRAL, turn == ALL);
    let center = max(share - total, 0.0);
    if center > 0.0 {
        sum += center * probe(tex, samp, uv, along, across, settings);
    }
    return sum / (total + center);
}

// The integral of the kernel summed across the axis.
fn profile(t: f32) -> f32 {
    return t - 2.0 / 3.0 * t * t * t + t * t * t * t * t * 0.2;
}

// One anisotropic fetch, by the texture unit or as it would do it.
fn probe(
    tex: texture_2d<f32>,
    samp: sampler,
    uv: vec2<f32>,
    along: vec2<f32>,
    across: vec2<f32>,
    settings: EwaSettings,
) -> vec4<f32> {
    if settings.sampler_anisotropy > 1u {
        return textureSampleGrad(tex, samp, uv, along, across);
    }
    return software_anisotropic(tex, samp, uv, along, across);
}

// One anisotropic fetch in the place of an ellipse, along its axes.
fn single(
    tex: texture_2d<f32>,
    samp: sampler,
    f: EwaFootprint,
    uv: vec2<f32>,
    settings: EwaSettings,
) -> vec4<f32> {
    let size = vec2<f32>(textureDimensions(tex, 0));
    let radius = settings.probe_radius_pixels;
    let width = PROBE_WIDTH * radius * f.minor_radius_texels;
    let length = max(SINGLE_LENGTH * radius * f.major_radius_texels, width);
    let along = f.major_direction * length / size;
    let across = vec2(-f.major_direction.y, f.major_direction.x) * width / size;
    return probe(tex, samp, uv, along, across, settings);
}

// Trilinear fetches of equal weight along the longer derivative.
fn software_anisotropic(
    tex: texture_2d<f32>,
    samp: sampler,
    uv: vec2<f32>,
    ddx: vec2<f32>,
    ddy: vec2<f32>,
) -> vec4<f32> {
    let size = vec2<f32>(textureDimensions(tex, 0));
    let a = length(ddx * size);
    let b = length(ddy * size);
    let long = max(a, b);
    if !is_finite(vec4(long, a, b, 0.0)) {
        return textureSampleLevel(tex, samp, uv, f32(textureNumLevels(tex)));
    }
    let line = select(ddy, ddx, a >= b);
    // Nothing is finer than a texel.
    let width = max(max(min(a, b), long / MOST_TAPS), 1.0);
    let count = clamp(ceil(long / width - TIE), 1.0, MOST_TAPS);
    let lod = log2(width);
    var sum = vec4(0.0);
    for (var i = 0.5; i < count; i += 1.0) {
        sum += textureSampleLevel(tex, samp, uv + line * (i / count - 0.5), lod);
    }
    return sum / count;
}

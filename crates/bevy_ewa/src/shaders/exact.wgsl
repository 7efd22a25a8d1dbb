// The weighted average of the texels of an ellipse: EWA proper (thesis 5.3 and 5.4). As
// `reference::exact`.
#define_import_path bevy_ewa::exact

#import bevy_ewa::footprint::{lod, HUGE}
#import bevy_ewa::kernel::{weight, GAUSSIAN_EDGE}
#import bevy_ewa::types::{
    EwaFootprint,
    EwaSettings,
    KERNEL_GAUSSIAN,
    METHOD_BILINEAR,
    METHOD_LINEAR,
}

// Heckbert's pad: the square of a texel's own radius.
const TEXEL_RADIUS_SQUARED: f32 = 1.0;
const NO_WEIGHT: f32 = 1e-6;
// More rows or columns than any budget has texels. Only a guard against endless loops.
const MOST_STEPS: i32 = 4200;

// An ellipse in a mip level, turned so that its rows are along its longer side.
struct Scan {
    // In texels; the centre of texel 0 is at 0.5.
    center: vec2<f32>,
    // Squares of the half-sides of the bounding box.
    xx: f32,
    yy: f32,
    xy: f32,
    determinant: f32,
    level: f32,
    texel_size: vec2<f32>,
    transposed: bool,
    kernel: u32,
}

// What a row has in common.
struct Row {
    first: i32,
    last: i32,
    // Where the squared distance is least, and how much it is there.
    middle: f32,
    least: f32,
}

fn exact(
    tex: texture_2d<f32>,
    samp: sampler,
    f: EwaFootprint,
    uv: vec2<f32>,
    settings: EwaSettings,
) -> vec4<f32> {
    let radius_texels = settings.kernel_radius_pixels * f.major_radius_texels;
    // Smaller than a texel: there is nothing to average but the texture's own reconstruction.
    let average = saturate(radius_texels - 1.0);
    let last = f32(textureNumLevels(tex)) - 1.0;
    let wanted = lod(f, settings);
    var shrunk = f;
    let excess = exp2(-max(wanted - last, 0.0));
    shrunk.major_radius_texels *= excess;
    shrunk.minor_radius_texels *= excess;
    let limited = clamp(wanted, 0.0, last);
    let fine = floor(limited);
    var part = 0.0;
    if settings.level_blend > 0.0 && fine < last {
        part = saturate((limited - fine - 1.0) / settings.level_blend + 1.0);
    }
    var color = vec4(0.0);
    if settings.uniform_levels == 1u {
        // No pixel may leave before this loop or skip a turn of it: the counter of one that sleeps
        // stands still, and the driver takes the level of all from that of the first.
        for (var level = 0.0; level <= last; level += 1.0) {
            if level == fine && average > 0.0 {
                color += one_level(tex, samp, shrunk, uv, level, settings) * (1.0 - part);
            } else if level == fine + 1.0 && part > 0.0 && average > 0.0 {
                color += one_level(tex, samp, shrunk, uv, level, settings) * part;
            }
        }
    } else if average > 0.0 {
        color = one_level(tex, samp, shrunk, uv, fine, settings);
        if part > 0.0 {
            color = mix(color, one_level(tex, samp, shrunk, uv, fine + 1.0, settings), part);
        }
    }
    if average < 1.0 {
        color = mix(textureSampleLevel(tex, samp, uv, 0.0), color, average);
    }
    return color;
}

fn one_level(
    tex: texture_2d<f32>,
    samp: sampler,
    f: EwaFootprint,
    uv: vec2<f32>,
    level: f32,
    settings: EwaSettings,
) -> vec4<f32> {
    let size = vec2<f32>(textureDimensions(tex, i32(level)));
    // A side that is one texel already gets no smaller: there, what is wider is no different.
    let scale = min(size / vec2<f32>(textureDimensions(tex, 0)), vec2(exp2(-level)));
    let radii = settings.kernel_radius_pixels * vec2(f.major_radius_texels, f.minor_radius_texels);
    let major = radii.x * radii.x;
    let minor = radii.y * radii.y;
    let c = f.major_direction.x;
    let s = f.major_direction.y;
    let xx = (major * c * c + minor * s * s) * scale.x * scale.x;
    let yy = (major * s * s + minor * c * c) * scale.y * scale.y;
    let pad = TEXEL_RADIUS_SQUARED;
    let bare = major * minor * (scale.x * scale.y) * (scale.x * scale.y);
    let transposed = yy > xx;
    var scan: Scan;
    scan.center = select(uv * size, (uv * size).yx, transposed);
    scan.xx = max(xx, yy) + pad;
    scan.yy = min(xx, yy) + pad;
    scan.xy = (major - minor) * c * s * scale.x * scale.y;
    // Multiplied out: the difference of the products cancels out for long ellipses.
    scan.determinant = bare + pad * (xx + yy) + pad * pad;
    scan.level = level;
    scan.texel_size = 1.0 / size;
    scan.transposed = transposed;
    scan.kernel = settings.kernel;
    if !(scan.xx < HUGE) {
        return textureSampleLevel(tex, samp, uv, level);
    }

    var sum = vec4(0.0);
    if settings.method == METHOD_LINEAR && settings.kernel == KERNEL_GAUSSIAN {
        sum = gaussian_pairs(tex, samp, scan);
    } else if settings.method == METHOD_LINEAR {
        sum = pairs(tex, samp, scan);
    } else if settings.method == METHOD_BILINEAR {
        sum = blocks(tex, samp, scan);
    } else {
        sum = texels(tex, samp, scan);
    }
    return sum;
}

fn fetch(tex: texture_2d<f32>, samp: sampler, scan: Scan, position: vec2<f32>) -> vec4<f32> {
    let at = select(position, position.yx, scan.transposed) * scan.texel_size;
    return textureSampleLevel(tex, samp, at, scan.level);
}

fn first_row(scan: Scan) -> i32 {
    return i32(ceil(scan.center.y - sqrt(scan.yy) - 0.5));
}

fn last_row(scan: Scan, first: i32) -> i32 {
    return min(i32(floor(scan.center.y + sqrt(scan.yy) - 0.5)), first + MOST_STEPS);
}

// The texels of a row inside the ellipse, by solving its equation for x.
fn row(scan: Scan, y: i32) -> Row {
    let dy = f32(y) + 0.5 - scan.center.y;
    let least = dy * dy / scan.yy;
    let half = sqrt(scan.determinant * max(1.0 - least, 0.0) / scan.yy);
    let middle = scan.center.x + dy * scan.xy / scan.yy;
    let first = i32(ceil(middle - half - 0.5));
    let last = min(i32(floor(middle + half - 0.5)), first + MOST_STEPS);
    return Row(first, last, middle, least);
}

// The weight of a texel of a row: a square around the row's middle, which does not cancel.
fn weight_in(scan: Scan, row: Row, x: i32) -> f32 {
    let dx = f32(x) + 0.5 - row.middle;
    return weight(scan.kernel, row.least + dx * dx * scan.yy / scan.determinant);
}

fn result(
    tex: texture_2d<f32>,
    samp: sampler,
    scan: Scan,
    sum: vec4<f32>,
    total: f32,
) -> vec4<f32> {
    if total < NO_WEIGHT {
        return fetch(tex, samp, scan, scan.center);
    }
    return sum / total;
}

fn texels(tex: texture_2d<f32>, samp: sampler, scan: Scan) -> vec4<f32> {
    var sum = vec4(0.0);
    var total = 0.0;
    let top = first_row(scan);
    let bottom = last_row(scan, top);
    for (var y = top; y <= bottom; y += 1) {
        let row = row(scan, y);
        for (var x = row.first; x <= row.last; x += 1) {
            let w = weight_in(scan, row, x);
            sum += w * fetch(tex, samp, scan, vec2(f32(x), f32(y)) + 0.5);
            total += w;
        }
    }
    return result(tex, samp, scan, sum, total);
}

// Two texels a fetch, from between them (equation 5.4).
fn pairs(tex: texture_2d<f32>, samp: sampler, scan: Scan) -> vec4<f32> {
    var sum = vec4(0.0);
    var total = 0.0;
    let top = first_row(scan);
    let bottom = last_row(scan, top);
    for (var y = top; y <= bottom; y += 1) {
        let row = row(scan, y);
        for (var x = row.first; x <= row.last; x += 2) {
            let a = weight_in(scan, row, x);
            let b = weight_in(scan, row, x + 1);
            let at = vec2(f32(x), f32(y)) + 0.5;
            let both = a + b;
            // A constant for all kernels without negative lobes.
            if scan.kernel <= KERNEL_GAUSSIAN || a * b >= 0.0 {
                let part = select(b / both, 0.0, both == 0.0);
                sum += both * fetch(tex, samp, scan, vec2(at.x + part, at.y));
            } else {
                sum += a * fetch(tex, samp, scan, at);
                sum += b * fetch(tex, samp, scan, vec2(at.x + 1.0, at.y));
            }
            total += both;
        }
    }
    return result(tex, samp, scan, sum, total);
}

// The same for a Gaussian, whose values along a row follow from one another: the quotient of
// neighbours changes by a constant factor.
fn gaussian_pairs(tex: texture_2d<f32>, samp: sampler, scan: Scan) -> vec4<f32> {
    var sum = vec4(0.0);
    var total = 0.0;
    let top = first_row(scan);
    let bottom = last_row(scan, top);
    let curvature = -2.0 * scan.yy / scan.determinant;
    let change = exp(2.0 * curvature);
    for (var y = top; y <= bottom; y += 1) {
        let row = row(scan, y);
        let dx = f32(row.first) + 0.5 - row.middle;
        var value = exp(dx * dx * curvature - 2.0 * row.least);
        var quotient = exp((2.0 * dx + 1.0) * curvature);
        for (var x = row.first; x <= row.last; x += 2) {
            let a = max(value - GAUSSIAN_EDGE, 0.0);
            value *= quotient;
            quotient *= change;
            let b = max(value - GAUSSIAN_EDGE, 0.0);
            value *= quotient;
            quotient *= change;
            let both = a + b;
            let part = select(b / both, 0.0, both == 0.0);
            sum += both * fetch(tex, samp, scan, vec2(f32(x) + 0.5 + part, f32(y) + 0.5));
            total += both;
        }
    }
    return result(tex, samp, scan, sum, total);
}

// Four texels a fetch, from where their weights are right column by column and row by row. Where
// one is negative, each alone.
fn blocks(tex: texture_2d<f32>, samp: sampler, scan: Scan) -> vec4<f32> {
    var sum = vec4(0.0);
    var total = 0.0;
    let top = first_row(scan);
    let bottom = last_row(scan, top);
    for (var y = top; y <= bottom; y += 2) {
        let upper = row(scan, y);
        let lower = row(scan, y + 1);
        var first = min(upper.first, lower.first);
        var last = max(upper.last, lower.last);
        if lower.first > lower.last {
            first = upper.first;
            last = upper.last;
        } else if upper.first > upper.last {
            first = lower.first;
            last = lower.last;
        }
        for (var x = first; x <= last; x += 2) {
            let w = vec4(
                weight_in(scan, upper, x),
                weight_in(scan, upper, x + 1),
                weight_in(scan, lower, x),
                weight_in(scan, lower, x + 1),
            );
            let all = w.x + w.y + w.z + w.w;
            let at = vec2(f32(x), f32(y)) + 0.5;
            if scan.kernel > KERNEL_GAUSSIAN && any(w < vec4(0.0)) {
                sum += w.x * fetch(tex, samp, scan, at);
                sum += w.y * fetch(tex, samp, scan, at + vec2(1.0, 0.0));
                sum += w.z * fetch(tex, samp, scan, at + vec2(0.0, 1.0));
                sum += w.w * fetch(tex, samp, scan, at + vec2(1.0, 1.0));
            } else if all > 0.0 {
                sum += all * fetch(tex, samp, scan, at + vec2(w.y + w.w, w.z + w.w) / all);
            }
            total += all;
        }
    }
    return result(tex, samp, scan, sum, total);
}

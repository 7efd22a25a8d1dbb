// The ellipse of a pixel in a texture, its mip level, its budget. As `reference::footprint`.
#define_import_path bevy_ewa::footprint

#import bevy_ewa::types::{EwaFootprint, EwaSettings, LEVEL_HARDWARE}

const PI: f32 = 3.14159265;
// Texels beyond which a radius is no more than "everything".
const HUGE: f32 = 1e12;
// As in `probes.wgsl`.
const TIE: f32 = 1e-3;
// 4 / sqrt(2): see `most_texels` of the reference.
const BORDER: f32 = 2.82842712;

fn disc(radius: f32) -> EwaFootprint {
    return EwaFootprint(radius, radius, vec2(1.0, 0.0), 1.0, log2(max(radius, 1.0 / HUGE)));
}

// By the bits: comparisons with what is not a number may be optimised away.
fn is_finite(v: vec4<f32>) -> bool {
    return all((bitcast<vec4<u32>>(v) & vec4(0x7f800000u)) != vec4(0x7f800000u));
}

// `gradient` is dpdx of the texture coordinates and dpdy, `size` in texels.
fn footprint(gradient: vec4<f32>, size: vec2<f32>, max_anisotropy: f32) -> EwaFootprint {
    let texels = gradient * size.xyxy;
    let largest = max(max(abs(texels.x), abs(texels.y)), max(abs(texels.z), abs(texels.w)));
    if !is_finite(texels) || largest > HUGE {
        return disc(HUGE);
    }
    if largest < 1.0 / HUGE {
        return disc(0.0);
    }
    // Of order 1, so that no square overflows or vanishes.
    let a = texels.xy / largest;
    let b = texels.zw / largest;
    let xx = a.x * a.x + b.x * b.x;
    let yy = a.y * a.y + b.y * b.y;
    let xy = a.x * a.y + b.x * b.y;
    // One eigenvalue from the trace and the other from the determinant: the difference that
    // equation 5.3 of the thesis takes cancels out.
    let root = sqrt((xx - yy) * (xx - yy) + 4.0 * xy * xy);
    let major_squared = (xx + yy + root) * 0.5;
    let major = sqrt(major_squared);
    let minor = abs(a.x * b.y - a.y * b.x) / major;
    var direction = select(
        vec2(xy, major_squared - xx),
        vec2(major_squared - yy, xy),
        xx >= yy,
    );
    let length_squared = dot(direction, direction);
    direction = select(vec2(1.0, 0.0), direction / sqrt(length_squared), length_squared > 1e-20);
    let lengths = vec2(length(a), length(b));
    let long = max(lengths.x, lengths.y);
    let short = min(lengths.x, lengths.y);
    let taps = ceil(long / max(short, long / 16.0) - TIE);
    return EwaFootprint(
        major * largest,
        max(minor, major / max_anisotropy) * largest,
        direction,
        major / max(minor, 1.0 / HUGE),
        log2(long / taps * largest),
    );
}

// The level of detail at which the exact methods read, not yet limited to the levels there are.
fn lod(f: EwaFootprint, settings: EwaSettings) -> f32 {
    var by_size = log2(max(f.minor_radius_texels, 1.0 / HUGE));
    if settings.level_of_detail == LEVEL_HARDWARE {
        by_size = f.hardware_lod;
    }
    return max(
        by_size + log2(settings.kernel_radius_pixels / settings.minor_radius_texels),
        lod_of_budget(f, settings),
    );
}

// The finest level of detail that keeps within the budget.
fn lod_of_budget(f: EwaFootprint, settings: EwaSettings) -> f32 {
    let a = settings.kernel_radius_pixels * f.major_radius_texels;
    let b = settings.kernel_radius_pixels * f.minor_radius_texels;
    let texels = settings.max_fetches * select(1.0, 0.5, settings.level_blend > 0.0);
    // Roots of a quadratic in the scale, whose coefficients are divided by a for their range.
    let sum = a + b;
    let constant = PI * 1.5 + 2.0 * BORDER - texels;
    if constant >= 0.0 {
        return log2(HUGE);
    }
    let square = PI * (a / max(sum, 1.0 / HUGE)) * (b / max(sum, 1.0 / HUGE));
    let linear = PI + BORDER;
    let scaled = -2.0 * constant / (linear + sqrt(linear * linear - 4.0 * square * constant));
    return 1.0 - log2(scaled) + log2(max(sum, 1.0 / HUGE));
}

// Decoding of wavelet textures (thesis section 3.5.3), one pixel at a time.
//
// A texel (x, y) of a wavelet plane holds the mean and the details of the pixels (2x, 2y) to
// (2x + 1, 2y + 1). Its neighbours' means foretell a part of the details (codec/predict.rs), the
// texel holds the rest. `luma`, `detail` and `chroma` are the textures of one `WaveletTexture`;
// what a packing does not have is never read.

#define_import_path bevy_wavelet_tex::decode

#import bevy_wavelet_tex::types::{
    ADDRESS_REPEAT,
    KIND_COLOR,
    KIND_COLOR_ALPHA,
    KIND_DECODED,
    KIND_DECODED_NORMAL,
    KIND_GRAY,
    KIND_NORMAL,
    PACKING_BC1,
    PACKING_BC3,
    PACKING_BC4,
    PACKING_BC7,
    PACKING_SPLIT,
    PlaneCoding,
    WaveletTexture,
    level_size,
}

// The mean (of packings without a wavelet: the value) in a texel.
fn load_mean(coding: PlaneCoding, packing: u32, texel: vec4<f32>) -> f32 {
    var stored = texel.r;
    if packing == PACKING_BC3 {
        stored = texel.a;
    } else if packing == PACKING_BC7 {
        stored = texel.b;
    }
    return coding.mean_min + stored * coding.mean_extent;
}

// HL, LH, HH in a texel, to which the prediction is to be added.
fn load_details(coding: PlaneCoding, packing: u32, texel: vec4<f32>) -> vec3<f32> {
    var stored = texel.rgb;
    if packing == PACKING_BC7 {
        // HH is dropped.
        stored.b = coding.centre.b;
    }
    let curved = 2.0 * (stored - coding.centre);
    let mixed = coding.range * sign(curved) * pow(abs(curved), vec3(coding.inverse_gamma));
    return vec3(
        dot(coding.unmix_hl, mixed),
        dot(coding.unmix_lh, mixed),
        dot(coding.unmix_hh, mixed),
    );
}

fn mean_at(
    plane: texture_2d_array<f32>,
    layer: u32,
    coding: PlaneCoding,
    packing: u32,
    quad: vec2<u32>,
    level: u32,
) -> f32 {
    return load_mean(coding, packing, textureLoad(plane, quad, layer, level));
}

// HL, LH, HH that the means around a quad foretell; the outermost go on beyond the edge.
// `size` is that of the plane in pixels.
fn predicted(
    plane: texture_2d_array<f32>,
    layer: u32,
    coding: PlaneCoding,
    packing: u32,
    quad: vec2<u32>,
    size: vec2<u32>,
    level: u32,
) -> vec3<f32> {
    let first = max(quad, vec2(1u)) - 1u;
    let last = min(quad + 1u, (size + 1u) / 2u - 1u);
    let left = mean_at(plane, layer, coding, packing, vec2(first.x, quad.y), level);
    let right = mean_at(plane, layer, coding, packing, vec2(last.x, quad.y), level);
    let above = mean_at(plane, layer, coding, packing, vec2(quad.x, first.y), level);
    let below = mean_at(plane, layer, coding, packing, vec2(quad.x, last.y), level);
    let diagonal = mean_at(plane, layer, coding, packing, first, level)
        - mean_at(plane, layer, coding, packing, vec2(last.x, first.y), level)
        - mean_at(plane, layer, coding, packing, vec2(first.x, last.y), level)
        + mean_at(plane, layer, coding, packing, last, level);
    return 2.0 * coding.predictor
        * vec3(left - right, above - below, coding.predictor * diagonal);
}

// One decoded value of a plane of `size` pixels.
fn plane_pixel(
    plane: texture_2d_array<f32>,
    detail: texture_2d_array<f32>,
    layer: u32,
    coding: PlaneCoding,
    packing: u32,
    position: vec2<u32>,
    size: vec2<u32>,
    level: u32,
) -> f32 {
    if packing == PACKING_BC4 {
        return mean_at(plane, layer, coding, packing, position, level);
    }
    let quad = position / 2u;
    let texel = textureLoad(plane, quad, layer, level);
    var stored = texel;
    if packing == PACKING_SPLIT {
        stored = textureLoad(detail, quad, layer, level);
    }
    var details = load_details(coding, packing, stored);
    if coding.predictor != 0.0 {
        details += predicted(plane, layer, coding, packing, quad, size, level);
    }
    // The pixel that the parity of the position selects (Eq. 3.17, with the factor 1/2).
    let s = 1.0 - 2.0 * vec2<f32>(position & vec2(1u));
    return load_mean(coding, packing, texel) + 0.5 * dot(details, vec3(s.x, s.y, s.x * s.y));
}

// Co and Cg of a texel that the texture unit has filtered, of `PACKING_BC1`.
fn load_chroma(texture: WaveletTexture, texel: vec4<f32>) -> vec2<f32> {
    let co = texture.planes[2];
    let cg = texture.planes[3];
    return vec2(
        co.mean_min + 0.5 * (texel.r + texel.b) * co.mean_extent,
        cg.mean_min + texel.g * cg.mean_extent,
    );
}

// Co and Cg at a point of a level, in pixels of luma.
fn chroma_at(
    texture: WaveletTexture,
    chroma: texture_2d_array<f32>,
    chroma_sampler: sampler,
    point: vec2<f32>,
    level: u32,
) -> vec2<f32> {
    let step = 1u << texture.subsampling;
    let size = (level_size(texture, level) + step - 1u) / step;
    if texture.chroma_packing == PACKING_BC1 {
        // What fills the last block must not be blended in.
        let inside = clamp(point / f32(step), vec2(0.5), vec2<f32>(size) - 0.5);
        let uv = inside / vec2<f32>(textureDimensions(chroma, level));
        let texel = textureSampleLevel(chroma, chroma_sampler, uv, 0, f32(level));
        return load_chroma(texture, texel);
    }
    let position = vec2<u32>(point) / step;
    let packing = texture.chroma_packing;
    return vec2(
        plane_pixel(chroma, chroma, 0u, texture.planes[2], packing, position, size, level),
        plane_pixel(chroma, chroma, 1u, texture.planes[3], packing, position, size, level),
    );
}

// YCoCg-R without rounding to RGB.
fn rgb_from_ycocg(y: f32, co_cg: vec2<f32>) -> vec3<f32> {
    let t = y - 0.5 * co_cg.y;
    let b = t - 0.5 * co_cg.x;
    return vec3(b + co_cg.x, co_cg.y + t, b);
}

// The unit normal whose X and Y these are; shortened to the unit circle where longer.
fn normal_from_xy(xy: vec2<f32>) -> vec3<f32> {
    let length_squared = dot(xy, xy);
    return vec3(
        xy * inverseSqrt(max(length_squared, 1.0)),
        sqrt(max(1.0 - length_squared, 0.0)),
    );
}

fn linear_from_srgb(encoded: vec3<f32>) -> vec3<f32> {
    let low = encoded / 12.92;
    let high = pow((encoded + 0.055) / 1.055, vec3(2.4));
    return select(high, low, encoded <= vec3(0.04045));
}

// Planes to colour in linear units with alpha, gray in all three, or a normal.
fn assembled(texture: WaveletTexture, luma: vec2<f32>, co_cg: vec2<f32>) -> vec4<f32> {
    if texture.kind == KIND_NORMAL {
        return vec4(normal_from_xy(luma), 1.0);
    }
    var color = saturate(vec3(luma.x));
    var alpha = 1.0;
    if texture.kind != KIND_GRAY {
        color = saturate(rgb_from_ycocg(luma.x, co_cg));
    }
    if texture.kind == KIND_COLOR_ALPHA {
        alpha = saturate(luma.y);
    }
    if texture.srgb != 0u {
        color = linear_from_srgb(color);
    }
    return vec4(color, alpha);
}

fn has_second_plane(texture: WaveletTexture) -> bool {
    return texture.kind == KIND_NORMAL || texture.kind == KIND_COLOR_ALPHA;
}

fn has_chroma(texture: WaveletTexture) -> bool {
    return texture.kind == KIND_COLOR || texture.kind == KIND_COLOR_ALPHA;
}

fn is_decoded(texture: WaveletTexture) -> bool {
    return texture.kind == KIND_DECODED || texture.kind == KIND_DECODED_NORMAL;
}

// A texel of a texture that was decoded on load.
fn from_decoded(texture: WaveletTexture, texel: vec4<f32>) -> vec4<f32> {
    if texture.kind == KIND_DECODED_NORMAL {
        return vec4(2.0 * texel.rgb - 1.0, 1.0);
    }
    if texture.srgb != 0u {
        return vec4(linear_from_srgb(texel.rgb), texel.a);
    }
    return texel;
}

// A decoded pixel in linear units: colour with alpha, gray in all three, or a normal.
fn pixel(
    texture: WaveletTexture,
    luma: texture_2d_array<f32>,
    detail: texture_2d_array<f32>,
    chroma: texture_2d_array<f32>,
    chroma_sampler: sampler,
    position: vec2<u32>,
    level: u32,
) -> vec4<f32> {
    if is_decoded(texture) {
        return from_decoded(texture, textureLoad(luma, position, 0u, level));
    }
    let size = level_size(texture, level);
    let packing = texture.luma_packing;
    var values = vec2(0.0);
    values.x = plane_pixel(luma, detail, 0u, texture.planes[0], packing, position, size, level);
    if has_second_plane(texture) {
        values.y = plane_pixel(luma, detail, 1u, texture.planes[1], packing, position, size, level);
    }
    var co_cg = vec2(0.0);
    if has_chroma(texture) {
        let centre = vec2<f32>(position) + 0.5;
        co_cg = chroma_at(texture, chroma, chroma_sampler, centre, level);
    }
    return assembled(texture, values, co_cg);
}

// The pixel of the next mip that the means of a level are without another fetch: that of 2 x 2
// pixels. Only wavelet packings have it, and `has_next_mip` says whether there are means.
fn next_mip_pixel(
    texture: WaveletTexture,
    luma: texture_2d_array<f32>,
    chroma: texture_2d_array<f32>,
    chroma_sampler: sampler,
    quad: vec2<u32>,
    level: u32,
) -> vec4<f32> {
    let packing = texture.luma_packing;
    var values = vec2(0.0);
    values.x = mean_at(luma, 0u, texture.planes[0], packing, quad, level);
    if has_second_plane(texture) {
        values.y = mean_at(luma, 1u, texture.planes[1], packing, quad, level);
    }
    var co_cg = vec2(0.0);
    if has_chroma(texture) {
        let centre = 2.0 * vec2<f32>(quad) + 1.0;
        co_cg = chroma_at(texture, chroma, chroma_sampler, centre, level);
    }
    return assembled(texture, values, co_cg);
}

fn has_next_mip(texture: WaveletTexture) -> bool {
    return !is_decoded(texture) && texture.luma_packing != PACKING_BC4;
}

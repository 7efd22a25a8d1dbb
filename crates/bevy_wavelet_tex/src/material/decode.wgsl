// Decoding and filtering of wavelet textures (thesis sections 3.5.3 and 3.6.2).
//
// Every plane is a layer of a BC3 texture whose texel (x, y) holds the coefficients of the pixels
// (2x, 2y) to (2x + 1, 2y + 1): details in RGB, the mean in A. One `textureLoad` decodes a pixel of
// a plane; filtering comes after decoding and linearising, never before.

#define_import_path bevy_wavelet_tex::decode

// How the coefficients of one plane are stored. `PlaneUniform` in uniform.rs.
struct PlaneCoding {
    // Rows of the matrix from stored details to HL, LH, HH.
    unmix_hl: vec3<f32>,
    // Mean that alpha 0 stands for.
    mean_min: f32,
    unmix_lh: vec3<f32>,
    // Alpha 1 stands for mean_min + mean_extent.
    mean_extent: f32,
    unmix_hh: vec3<f32>,
    // Largest stored detail.
    range: f32,
    // Exponent that undoes the power curve.
    inverse_gamma: f32,
}

// One texture. `TextureUniform` in uniform.rs.
struct WaveletTexture {
    // Width and height of the image, in pixels.
    size: vec2<u32>,
    levels: u32,
    // KIND_*
    kind: u32,
    // 1 where values are sRGB-encoded, 0 where they are data.
    srgb: u32,
    // ADDRESS_*
    address: u32,
    planes: array<PlaneCoding, 3>,
}

const KIND_GRAY = 0u;
const KIND_COLOR = 1u;
const KIND_NORMAL = 2u;
// Decoded on load, where the adapter lacks BC: layer 0 holds the pixels, normals as 0.5 + 0.5 n.
const KIND_DECODED = 3u;
const KIND_DECODED_NORMAL = 4u;

const ADDRESS_REPEAT = 0u;
const ADDRESS_CLAMP = 1u;
const ADDRESS_MIRROR = 2u;

// LL, HL, LH, HH of a stored texel.
fn coefficients(coding: PlaneCoding, texel: vec4<f32>) -> vec4<f32> {
    let curved = 2.0 * texel.rgb - 1.0;
    let mixed = coding.range * sign(curved) * pow(abs(curved), vec3(coding.inverse_gamma));
    return vec4(
        2.0 * (coding.mean_min + texel.a * coding.mean_extent),
        dot(coding.unmix_hl, mixed),
        dot(coding.unmix_lh, mixed),
        dot(coding.unmix_hh, mixed),
    );
}

// The pixel of a quad that a position selects by its parity (Eq. 3.17, with the factor 1/2).
fn pixel_of_quad(c: vec4<f32>, position: vec2<u32>) -> f32 {
    let s = 1.0 - 2.0 * vec2<f32>(position & vec2(1u));
    return 0.5 * dot(c, vec4(1.0, s.x, s.y, s.x * s.y));
}

// One decoded value of a plane.
fn plane_pixel(
    plane: texture_2d_array<f32>,
    layer: u32,
    coding: PlaneCoding,
    position: vec2<u32>,
    level: u32,
) -> f32 {
    let texel = textureLoad(plane, position / 2u, layer, level);
    return pixel_of_quad(coefficients(coding, texel), position);
}

// YCoCg-R without rounding to RGB.
fn rgb_from_ycocg(y: f32, co: f32, cg: f32) -> vec3<f32> {
    let t = y - 0.5 * cg;
    let b = t - 0.5 * co;
    return vec3(b + co, cg + t, b);
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

// A decoded pixel in linear units: colour, gray in all three, or a normal.
// `chroma` is read for colour only.
fn pixel(
    texture: WaveletTexture,
    luma: texture_2d_array<f32>,
    chroma: texture_2d_array<f32>,
    position: vec2<u32>,
    level: u32,
) -> vec3<f32> {
    var value: vec3<f32>;
    switch texture.kind {
        case KIND_GRAY: {
            value = vec3(saturate(plane_pixel(luma, 0u, texture.planes[0], position, level)));
        }
        case KIND_COLOR: {
            value = saturate(rgb_from_ycocg(
                plane_pixel(luma, 0u, texture.planes[0], position, level),
                plane_pixel(chroma, 0u, texture.planes[1], position / 2u, level),
                plane_pixel(chroma, 1u, texture.planes[2], position / 2u, level),
            ));
        }
        case KIND_NORMAL: {
            value = normal_from_xy(vec2(
                plane_pixel(luma, 0u, texture.planes[0], position, level),
                plane_pixel(luma, 1u, texture.planes[1], position, level),
            ));
        }
        case KIND_DECODED_NORMAL: {
            value = 2.0 * textureLoad(luma, position, 0u, level).rgb - 1.0;
        }
        default: {
            value = textureLoad(luma, position, 0u, level).rgb;
        }
    }
    if texture.srgb != 0u {
        value = linear_from_srgb(value);
    }
    return value;
}

// Size of a mip level in pixels.
fn level_size(texture: WaveletTexture, level: u32) -> vec2<u32> {
    return max(texture.size >> vec2(level), vec2(1u));
}

// The pixel inside the image that stands for one outside.
fn addressed(position: vec2<i32>, size: vec2<u32>, address: u32) -> vec2<u32> {
    let n = vec2<i32>(size);
    switch address {
        case ADDRESS_CLAMP: {
            return vec2<u32>(clamp(position, vec2(0), n - 1));
        }
        case ADDRESS_MIRROR: {
            let period = 2 * n;
            let p = ((position % period) + period) % period;
            return vec2<u32>(min(p, period - 1 - p));
        }
        default: {
            return vec2<u32>(((position % n) + n) % n);
        }
    }
}

// Coordinates far from 0 lose their fraction: whole periods are taken off first.
fn reduced(uv: vec2<f32>, address: u32) -> vec2<f32> {
    switch address {
        case ADDRESS_CLAMP: {
            return clamp(uv, vec2(-1.0), vec2(2.0));
        }
        case ADDRESS_MIRROR: {
            return uv - 2.0 * floor(0.5 * uv);
        }
        default: {
            return uv - floor(uv);
        }
    }
}

// The nearest pixel of a level.
fn sample_nearest(
    texture: WaveletTexture,
    luma: texture_2d_array<f32>,
    chroma: texture_2d_array<f32>,
    uv: vec2<f32>,
    level: u32,
) -> vec3<f32> {
    let size = level_size(texture, level);
    let position = vec2<i32>(floor(reduced(uv, texture.address) * vec2<f32>(size)));
    return pixel(texture, luma, chroma, addressed(position, size, texture.address), level);
}

// The four nearest pixels of a level, decoded, linearised, then weighted.
fn sample_bilinear(
    texture: WaveletTexture,
    luma: texture_2d_array<f32>,
    chroma: texture_2d_array<f32>,
    uv: vec2<f32>,
    level: u32,
) -> vec3<f32> {
    let size = level_size(texture, level);
    let centered = reduced(uv, texture.address) * vec2<f32>(size) - 0.5;
    let first = floor(centered);
    let weight = centered - first;
    let p00 = addressed(vec2<i32>(first), size, texture.address);
    let p11 = addressed(vec2<i32>(first) + 1, size, texture.address);
    let v00 = pixel(texture, luma, chroma, p00, level);
    let v10 = pixel(texture, luma, chroma, vec2(p11.x, p00.y), level);
    let v01 = pixel(texture, luma, chroma, vec2(p00.x, p11.y), level);
    let v11 = pixel(texture, luma, chroma, p11, level);
    return mix(mix(v00, v10, weight.x), mix(v01, v11, weight.x), weight.y);
}

// The level of detail of a footprint, 0 at one pixel per screen pixel; `ddx`, `ddy` are the
// derivatives of uv, so that they can be taken in uniform control flow.
fn level_of_detail(texture: WaveletTexture, ddx: vec2<f32>, ddy: vec2<f32>, bias: f32) -> f32 {
    let size = vec2<f32>(texture.size);
    let x = ddx * size;
    let y = ddy * size;
    let footprint = max(max(dot(x, x), dot(y, y)), 1e-20);
    return clamp(0.5 * log2(footprint) + bias, 0.0, f32(texture.levels - 1u));
}

// The value that the top-left fragment of each 2 x 2 quad has, for whole numbers. Hardware takes
// one level per quad too, and some software drivers misread a `textureLoad` whose level differs
// within one.
fn quad_uniform(value: f32, frag_coord: vec2<f32>) -> f32 {
    let odd = vec2<u32>(frag_coord) & vec2(1u);
    let row = value - f32(odd.x) * dpdxFine(value);
    return row - f32(odd.y) * dpdyFine(row);
}

// A filtered value in linear units; the filter is chosen by WAVELET_FILTER_NEAREST (nearest pixel,
// nearest level), WAVELET_FILTER_BILINEAR (bilinear, nearest level), or neither: trilinear.
fn sample(
    texture: WaveletTexture,
    luma: texture_2d_array<f32>,
    chroma: texture_2d_array<f32>,
    uv: vec2<f32>,
    frag_coord: vec2<f32>,
    bias: f32,
) -> vec3<f32> {
    let lod = level_of_detail(texture, dpdx(uv), dpdy(uv), bias);
#ifdef WAVELET_FILTER_NEAREST
    let level = u32(quad_uniform(round(lod), frag_coord));
    return sample_nearest(texture, luma, chroma, uv, level);
#else
#ifdef WAVELET_FILTER_BILINEAR
    let level = u32(quad_uniform(round(lod), frag_coord));
    return sample_bilinear(texture, luma, chroma, uv, level);
#else
    let fine = quad_uniform(floor(lod), frag_coord);
    let coarse = min(fine + 1.0, f32(texture.levels - 1u));
    let weight = saturate(lod - fine);
    let value = sample_bilinear(texture, luma, chroma, uv, u32(fine));
    if weight == 0.0 {
        return value;
    }
    return mix(value, sample_bilinear(texture, luma, chroma, uv, u32(coarse)), weight);
#endif
#endif
}

// Filtering of wavelet textures (thesis section 3.6.2): after decoding and linearising, never before.

#define_import_path bevy_wavelet_tex::sampling

#import bevy_wavelet_tex::decode::{has_next_mip, next_mip_pixel, pixel}
#import bevy_wavelet_tex::types::{ADDRESS_CLAMP, ADDRESS_MIRROR, WaveletTexture, level_size}

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
    detail: texture_2d_array<f32>,
    chroma: texture_2d_array<f32>,
    chroma_sampler: sampler,
    uv: vec2<f32>,
    level: u32,
) -> vec4<f32> {
    let size = level_size(texture, level);
    let position = vec2<i32>(floor(reduced(uv, texture.address) * vec2<f32>(size)));
    let inside = addressed(position, size, texture.address);
    return pixel(texture, luma, detail, chroma, chroma_sampler, inside, level);
}

// Four neighbours and the weights between them.
struct Footprint {
    first: vec2<u32>,
    last: vec2<u32>,
    weight: vec2<f32>,
}

fn footprint(texture: WaveletTexture, uv: vec2<f32>, size: vec2<u32>) -> Footprint {
    let centered = reduced(uv, texture.address) * vec2<f32>(size) - 0.5;
    let first = floor(centered);
    return Footprint(
        addressed(vec2<i32>(first), size, texture.address),
        addressed(vec2<i32>(first) + 1, size, texture.address),
        centered - first,
    );
}

// The four pixels of a footprint, decoded and linearised, then weighted; with `of_means` they are those
// of the next mip.
fn blended(
    texture: WaveletTexture,
    luma: texture_2d_array<f32>,
    detail: texture_2d_array<f32>,
    chroma: texture_2d_array<f32>,
    chroma_sampler: sampler,
    f: Footprint,
    level: u32,
    of_means: bool,
) -> vec4<f32> {
    var corners = array(f.first, vec2(f.last.x, f.first.y), vec2(f.first.x, f.last.y), f.last);
    var values: array<vec4<f32>, 4>;
    for (var i = 0; i < 4; i += 1) {
        if of_means {
            values[i] = next_mip_pixel(texture, luma, chroma, chroma_sampler, corners[i], level);
        } else {
            values[i] = pixel(texture, luma, detail, chroma, chroma_sampler, corners[i], level);
        }
    }
    let w = f.weight;
    return mix(mix(values[0], values[1], w.x), mix(values[2], values[3], w.x), w.y);
}

// Bilinear in the pixels of a level.
fn sample_bilinear(
    texture: WaveletTexture,
    luma: texture_2d_array<f32>,
    detail: texture_2d_array<f32>,
    chroma: texture_2d_array<f32>,
    chroma_sampler: sampler,
    uv: vec2<f32>,
    level: u32,
) -> vec4<f32> {
    let f = footprint(texture, uv, level_size(texture, level));
    return blended(texture, luma, detail, chroma, chroma_sampler, f, level, false);
}

// Bilinear in the means of a level: the next mip, as the codec's box filter has it.
fn sample_means_bilinear(
    texture: WaveletTexture,
    luma: texture_2d_array<f32>,
    chroma: texture_2d_array<f32>,
    chroma_sampler: sampler,
    uv: vec2<f32>,
    level: u32,
) -> vec4<f32> {
    let size = level_size(texture, level);
    // Of an odd size the last quad is half outside; its pixels still are where they are.
    let extent = vec2<f32>(size) / vec2<f32>(2u * ((size + 1u) / 2u));
    let f = footprint(texture, reduced(uv, texture.address) * extent, (size + 1u) / 2u);
    return blended(texture, luma, luma, chroma, chroma_sampler, f, level, true);
}

// Squared lengths of a footprint's axes in pixels of the first level, the longer first; `ddx`, `ddy`
// are the derivatives of uv, so that they can be taken in uniform control flow.
fn footprint_squared(texture: WaveletTexture, ddx: vec2<f32>, ddy: vec2<f32>) -> vec2<f32> {
    let size = vec2<f32>(texture.size);
    let x = ddx * size;
    let y = ddy * size;
    let squared = vec2(dot(x, x), dot(y, y));
    return max(vec2(max(squared.x, squared.y), min(squared.x, squared.y)), vec2(1e-20));
}

// The level of detail of a footprint, 0 at one pixel per screen pixel.
fn level_of_detail(texture: WaveletTexture, ddx: vec2<f32>, ddy: vec2<f32>, bias: f32) -> f32 {
    let longest = footprint_squared(texture, ddx, ddy).x;
    return clamp(0.5 * log2(longest) + bias, 0.0, f32(texture.levels - 1u));
}

// The value that the top-left fragment of each 2 x 2 quad has, for whole numbers. Hardware takes
// one level per quad too, and some software drivers misread a `textureLoad` whose level differs
// within one.
fn quad_uniform(value: f32, frag_coord: vec2<f32>) -> f32 {
    let odd = vec2<u32>(frag_coord) & vec2(1u);
    let row = value - f32(odd.x) * dpdxFine(value);
    return row - f32(odd.y) * dpdyFine(row);
}

// What the filter's name says: one level or two, one pixel of each or four.
#ifdef WAVELET_FILTER_NEAREST
const ONE_LEVEL = true;
const ONE_PIXEL = true;
#else ifdef WAVELET_FILTER_BILINEAR
const ONE_LEVEL = true;
const ONE_PIXEL = false;
#else ifdef WAVELET_FILTER_NEAREST_MIP_LINEAR
const ONE_LEVEL = false;
const ONE_PIXEL = true;
#else
const ONE_LEVEL = false;
const ONE_PIXEL = false;
#endif

// A filtered value of one level.
fn sample_level(
    texture: WaveletTexture,
    luma: texture_2d_array<f32>,
    detail: texture_2d_array<f32>,
    chroma: texture_2d_array<f32>,
    chroma_sampler: sampler,
    uv: vec2<f32>,
    level: u32,
) -> vec4<f32> {
    if ONE_PIXEL {
        return sample_nearest(texture, luma, detail, chroma, chroma_sampler, uv, level);
    }
    return sample_bilinear(texture, luma, detail, chroma, chroma_sampler, uv, level);
}

// A filtered value in linear units; the filter is chosen by WAVELET_FILTER_NEAREST (nearest pixel,
// nearest level), WAVELET_FILTER_NEAREST_MIP_LINEAR (nearest pixel of two levels),
// WAVELET_FILTER_BILINEAR (nearest level), WAVELET_FILTER_ONE_FETCH (trilinear, the coarser level
// from the means of the finer), or none of them: trilinear. The anisotropic filter is in
// `bevy_wavelet_tex::anisotropic`.
fn sample(
    texture: WaveletTexture,
    luma: texture_2d_array<f32>,
    detail: texture_2d_array<f32>,
    chroma: texture_2d_array<f32>,
    chroma_sampler: sampler,
    uv: vec2<f32>,
    frag_coord: vec2<f32>,
    bias: f32,
) -> vec4<f32> {
    let lod = level_of_detail(texture, dpdx(uv), dpdy(uv), bias);
    let fine = quad_uniform(select(floor(lod), round(lod), ONE_LEVEL), frag_coord);
    let value = sample_level(texture, luma, detail, chroma, chroma_sampler, uv, u32(fine));
    let weight = select(saturate(lod - fine), 0.0, ONE_LEVEL);
    if weight == 0.0 {
        return value;
    }
    var other: vec4<f32>;
#ifdef WAVELET_FILTER_ONE_FETCH
    if has_next_mip(texture) {
        other = sample_means_bilinear(texture, luma, chroma, chroma_sampler, uv, u32(fine));
        return mix(value, other, weight);
    }
#endif
    let coarse = u32(min(fine + 1.0, f32(texture.levels - 1u)));
    other = sample_level(texture, luma, detail, chroma, chroma_sampler, uv, coarse);
    return mix(value, other, weight);
}

// A colour in two channels: luminance, and one of the two chrominances by the parity of the pixel
// (thesis 4.4, listing 4.1). Linear, so that blending packed values is packing blended values.

#define_import_path bevy_ycocg_fb::pack

const LARGEST_HALF: f32 = 65504.0;

// 8-bit targets hold no negative values (thesis 4.7.2). Not 1/2: 128/255 is a value they hold, so
// that gray stays gray.
const CHROMA_BIAS: f32 = 128.0 / 255.0;

// Luminance, orange, green (thesis Eq. 3.3): none is larger than the largest of r, g and b.
fn ycocg_from_rgb(rgb: vec3<f32>) -> vec3<f32> {
    return vec3(
        dot(rgb, vec3(0.25, 0.5, 0.25)),
        0.5 * (rgb.r - rgb.b),
        dot(rgb, vec3(-0.25, 0.5, -0.25)),
    );
}

fn rgb_from_ycocg(ycocg: vec3<f32>) -> vec3<f32> {
    let rest = ycocg.x - ycocg.z;
    return vec3(rest + ycocg.y, ycocg.x + ycocg.z, rest - ycocg.y);
}

// Whether a pixel stores Co, not Cg.
fn stores_orange(pixel: vec2<i32>) -> bool {
    return ((pixel.x ^ pixel.y) & 1) == 0;
}

// In the bits, because a shader compiler may assume that there is no NaN.
fn is_finite(x: f32) -> bool {
    return (bitcast<u32>(x) & 0x7f800000u) != 0x7f800000u;
}

fn is_nan(x: f32) -> bool {
    return (bitcast<u32>(x) & 0x7fffffffu) > 0x7f800000u;
}

// NaN is black, what is negative is black, what is too bright is the brightest.
fn sanitized(x: f32, brightest: f32) -> f32 {
    return select(clamp(x, 0.0, brightest), 0.0, is_nan(x));
}

fn sanitized_rgb(rgb: vec3<f32>, brightest: f32) -> vec3<f32> {
    return vec3(
        sanitized(rgb.r, brightest),
        sanitized(rgb.g, brightest),
        sanitized(rgb.b, brightest),
    );
}

fn srgb_from_linear(linear: vec3<f32>) -> vec3<f32> {
    let low = 12.92 * linear;
    let high = 1.055 * pow(linear, vec3(1.0 / 2.4)) - 0.055;
    return select(high, low, linear <= vec3(0.0031308));
}

// The two channels of `rgb` at a pixel, without bias.
fn channels(rgb: vec3<f32>, frag_coord: vec2<f32>) -> vec2<f32> {
    let ycocg = ycocg_from_rgb(rgb);
    return vec2(ycocg.x, select(ycocg.z, ycocg.y, stores_orange(vec2<i32>(frag_coord))));
}

// What a fragment shader writes instead of `color`, at the very end: `frag_coord` is its
// `@builtin(position)`. Without the shader def YCOCG_FB_PACK it is `color` itself, so that one
// shader serves packed cameras and others.
fn pack_fragment(color: vec4<f32>, frag_coord: vec4<f32>) -> vec4<f32> {
#ifdef YCOCG_FB_PACK
    let alpha = select(1.0, color.a, is_finite(color.a));
#ifdef YCOCG_FB_UNORM8
    let packed = packed_unorm8(sanitized_rgb(color.rgb, 1.0), alpha, frag_coord.xy);
#else
    let packed = channels(sanitized_rgb(color.rgb, LARGEST_HALF), frag_coord.xy);
#endif
#ifdef BLEND_MULTIPLY
    // Two of four products: exact for gray, others lose their hue (but not their luminance).
    return vec4(packed.x, packed.x, 0.0, alpha);
#else
    return vec4(packed, 0.0, alpha);
#endif
#else
    return color;
#endif
}

#ifdef YCOCG_FB_UNORM8
fn packed_unorm8(rgb: vec3<f32>, alpha: f32, frag_coord: vec2<f32>) -> vec2<f32> {
#ifdef PREMULTIPLY_ALPHA
    // The blending adds (1 - alpha) of the bias that is there already. Gamma encoding is done
    // before the multiplication.
    let coverage = select(1.0, alpha, alpha > 0.0);
    let encoded = srgb_from_linear(min(rgb / coverage, vec3(1.0))) * coverage;
    return channels(encoded, frag_coord) + vec2(0.0, CHROMA_BIAS * alpha);
#else
    return channels(srgb_from_linear(rgb), frag_coord) + vec2(0.0, CHROMA_BIAS);
#endif
}
#endif

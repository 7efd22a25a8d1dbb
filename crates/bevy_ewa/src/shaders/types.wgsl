// How a texture is filtered. Keep in sync with `uniform.rs`, which makes one of `EwaSettings`.
#define_import_path bevy_ewa::types

struct EwaSettings {
    // One of METHOD_*.
    method: u32,
    // 3, 5 or 7; 0 is by aspect.
    probes: u32,
    // One of KERNEL_*.
    kernel: u32,
    // One of LEVEL_*.
    level_of_detail: u32,
    // Where the kernel ends.
    kernel_radius_pixels: f32,
    // The radius of a Gaussian kernel that blurs as much.
    probe_radius_pixels: f32,
    max_anisotropy: f32,
    minor_radius_texels: f32,
    level_blend: f32,
    max_fetches: f32,
    spatial_threshold: f32,
    // From 2 on, probes are left to the texture unit.
    sampler_anisotropy: u32,
    // 1: texture coordinates may be reduced by 2.
    periodic: u32,
    // Number of the frame, for the temporal methods.
    frame: u32,
    // 1: the driver reads all pixels of a quad from the mip level of the first. Every level is then
    // visited by all of them.
    uniform_levels: u32,
    padding: u32,
}

const METHOD_REFERENCE: u32 = 0u;
const METHOD_LINEAR: u32 = 1u;
const METHOD_BILINEAR: u32 = 2u;
const METHOD_APPROXIMATE: u32 = 3u;
const METHOD_SPATIAL: u32 = 4u;
const METHOD_TEMPORAL: u32 = 5u;
const METHOD_SPATIAL_TEMPORAL: u32 = 6u;
const METHOD_SOFTWARE_ANISOTROPIC: u32 = 7u;
const METHOD_HARDWARE: u32 = 8u;

const KERNEL_BOX: u32 = 0u;
const KERNEL_TENT: u32 = 1u;
const KERNEL_GAUSSIAN: u32 = 2u;
const KERNEL_MITCHELL_NETRAVALI: u32 = 3u;
const KERNEL_LANCZOS: u32 = 4u;

const LEVEL_MINOR_RADIUS: u32 = 0u;
const LEVEL_HARDWARE: u32 = 1u;

// What a pixel of one pixel in radius covers of a texture, in texels of the finest level.
struct EwaFootprint {
    major_radius_texels: f32,
    // After the anisotropy is limited.
    minor_radius_texels: f32,
    // Of length 1.
    major_direction: vec2<f32>,
    // Ratio of the radii before it is limited.
    anisotropy: f32,
    // log2 of the minor radius by the formula of texture units.
    hardware_lod: f32,
}

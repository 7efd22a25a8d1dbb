// What the voxels hold, seen by a camera: one ray a pixel through the sub-voxels.

#import bevy_core_pipeline::fullscreen_vertex_shader::FullscreenVertexOutput
#import bevy_render::view::View
#import bevy_voxel_gi::albedo::surface_albedo
#import bevy_voxel_gi::atlas::{atlas_texel, unpack_light}
#import bevy_voxel_gi::faces::{face_key, keys, surface_normal}
#import bevy_voxel_gi::material::Material
#import bevy_voxel_gi::trace::facing
#import bevy_voxel_gi::volume::{FACES, FINE, face_towards, key_material, level_corner,
    level_voxel_size, volume}
#import bevy_voxel_gi::walk::{NOTHING, Touched, walk}

@group(1) @binding(0) var<uniform> view: View;
@group(1) @binding(1) var<storage, read> materials: array<Material>;
@group(1) @binding(2) var<storage, read> radiance: array<vec2<u32>>;
@group(1) @binding(3) var light_texture: texture_3d<f32>;

const BACKGROUND: vec3<f32> = vec3(0.02, 0.02, 0.03);
// Where a surface shows its back.
const BACK: vec3<f32> = vec3(0.05, 0.0, 0.05);

// How far a ray is in a cube, in units of its direction: from and to.
fn span_in_box(origin: vec3<f32>, direction: vec3<f32>, low: vec3<f32>, high: vec3<f32>)
    -> vec2<f32> {
    let ray = select(direction, vec3(1e-12), abs(direction) < vec3(1e-12));
    let a = (low - origin) / ray;
    let b = (high - origin) / ray;
    let near = min(a, b);
    let far = max(a, b);
    return vec2(max(near.x, max(near.y, near.z)), min(far.x, min(far.y, far.z)));
}

// The axis across which a ray enters a cube.
fn entry_axis(origin: vec3<f32>, direction: vec3<f32>, low: vec3<f32>, high: vec3<f32>) -> u32 {
    let ray = select(direction, vec3(1e-12), abs(direction) < vec3(1e-12));
    let near = min((low - origin) / ray, (high - origin) / ray);
    return select(select(2u, 1u, near.y > near.z), 0u, near.x > near.y && near.x > near.z);
}

fn world_from_pixel(uv: vec2<f32>, depth: f32) -> vec3<f32> {
    let ndc = vec4(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y, depth, 1.0);
    let world = view.world_from_clip * ndc;
    return world.xyz / world.w;
}

// As a display shows it: very bright light is not lost.
fn shown(light: vec3<f32>) -> vec3<f32> {
    let exposed = light / volume.storage_scale * view.exposure;
    return exposed / (1.0 + max(exposed.r, max(exposed.g, exposed.b)));
}

// Of the smallest level in which a ray meets something; larger ones count where they are clearly
// nearer.
fn nearest_touched(eye: vec3<f32>, direction: vec3<f32>) -> Touched {
    var nearest: Touched;
    nearest.index = NOTHING;
    var least = 3e38;
    for (var level = 0u; level < volume.level_count; level++) {
        let size = level_voxel_size(level);
        let origin = (eye - level_corner(level)) / size;
        let span = span_in_box(origin, direction, vec3(0.0), vec3(f32(volume.resolution)));
        if (span.x > span.y || span.y < 0.0) {
            continue;
        }
        let start = origin + direction * max(span.x + 1e-3, 0.0);
        let touched = walk(level, start, direction, 0.0, 1e9);
        if (touched.index == NOTHING) {
            continue;
        }
        let found_size = level_voxel_size(touched.level);
        let center = level_corner(touched.level) + found_size * (vec3<f32>(touched.voxel) + 0.5);
        let distance = dot(center - eye, direction);
        if (distance < least - 2.0 * found_size) {
            nearest = touched;
            least = distance;
        }
    }
    return nearest;
}

@fragment
fn fragment(in: FullscreenVertexOutput) -> @location(0) vec4<f32> {
    let eye = world_from_pixel(in.uv, 1.0);
    let direction = normalize(world_from_pixel(in.uv, 0.5) - eye);
    let touched = nearest_touched(eye, direction);
    if (touched.index == NOTHING) {
        return vec4(BACKGROUND, 1.0);
    }
    let index = touched.index;
    let voxel = touched.voxel;
    let low_cell = vec3<f32>(voxel) + vec3<f32>(touched.cell) / f32(FINE);
    let place = (eye - level_corner(touched.level)) / level_voxel_size(touched.level);
    let entered = entry_axis(place, direction, low_cell, low_cell + 1.0 / f32(FINE));
#ifdef FIELD_OCCUPANCY
    let checker = f32((voxel.x + voxel.y + voxel.z) & 1u);
    let shade = array(0.45, 0.8, 0.6);
    return vec4(vec3(shade[entered] * (0.85 + 0.15 * checker)), 1.0);
#else
    // The face that was entered, or else another that shows.
    var axis = entered;
    let seen = facing(touched, direction, NOTHING);
    if (seen.shown == 0u) {
        return vec4(BACK, 1.0);
    }
    while ((seen.shown & (1u << axis)) == 0u) {
        axis = (axis + 1u) % 3u;
    }
    let face = face_towards(axis, -direction[axis]);
#ifdef FIELD_NORMAL
    return vec4(0.5 + 0.5 * surface_normal(index, face), 1.0);
#endif
#ifdef FIELD_IRRADIANCE
    let texel = textureLoad(light_texture, atlas_texel(index, face), 0);
    return vec4(shown(texel.rgb / max(texel.a, 1e-6)), 1.0);
#endif
#ifdef FIELD_ALBEDO
    let material = materials[key_material(keys[FACES * index + face])];
    return vec4(surface_albedo(index, face, material.albedo), 1.0);
#endif
#ifdef FIELD_RADIANCE
    return vec4(shown(unpack_light(radiance[FACES * index + face]).rgb), 1.0);
#endif
#endif
}

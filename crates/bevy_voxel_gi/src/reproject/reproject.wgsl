// What a camera sees of each surface (thesis section 6.5.2): where its points are in the picture and
// nothing is in front of them, the colour of the G-buffer. One workgroup a surface, one thread a
// point of it.

#import bevy_pbr::pbr_deferred_types::{unpack_24bit_normal, unpack_unorm4x8_}
#import bevy_pbr::utils::octahedral_decode
#import bevy_render::view::View
#import bevy_voxel_gi::albedo::{pack_seen, seen_tag}
#import bevy_voxel_gi::entry::{load_entry, work_item}
#import bevy_voxel_gi::faces::face_key
#import bevy_voxel_gi::surface::{point_count, surface_point}
#import bevy_voxel_gi::volume::{FACES, level_corner, level_of_index, level_voxel_size,
    voxel_of_index}

@group(1) @binding(2) var<storage, read_write> seen: array<u32>;
@group(1) @binding(3) var<uniform> view: View;
@group(1) @binding(4) var depth_texture: texture_depth_2d;
@group(1) @binding(5) var deferred_texture: texture_2d<u32>;

const THREADS: u32 = 16u;
// Per point: the colour seen there, and whether it is.
var<workgroup> colors: array<vec4<f32>, 16>;

// What the camera sees may be this far from a point, in voxels.
const NEAR: f32 = 0.5;
// Cosine between its normal and the surface's.
const LEAST_FACING: f32 = 0.7;

// The diffuse colour that a camera sees at a place, and 1; 0 if it does not see it.
fn color_at(position: vec3<f32>, normal: vec3<f32>, voxel_size: f32) -> vec4<f32> {
    let clip = view.clip_from_world * vec4(position, 1.0);
    let ndc = clip.xyz / clip.w;
    if (clip.w <= 0.0 || any(abs(ndc.xy) >= vec2(1.0))) {
        return vec4(0.0);
    }
    let uv = vec2(0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y);
    let pixel = vec2<i32>(view.viewport.xy + uv * view.viewport.zw);
    let depth = textureLoad(depth_texture, pixel, 0);
    // Nothing is drawn there.
    if (depth == 0.0) {
        return vec4(0.0);
    }
    let world = view.world_from_clip * vec4(ndc.xy, depth, 1.0);
    if (distance(world.xyz / world.w, position) > NEAR * voxel_size) {
        return vec4(0.0);
    }
    let texel = textureLoad(deferred_texture, pixel, 0);
    if (dot(octahedral_decode(unpack_24bit_normal(texel.a)), normal) < LEAST_FACING) {
        return vec4(0.0);
    }
    let base = pow(unpack_unorm4x8_(texel.r).rgb, vec3(2.2));
    let metallic = unpack_unorm4x8_(texel.b).g;
    return vec4(base * (1.0 - metallic), 1.0);
}

@compute @workgroup_size(16)
fn reproject(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let entry = load_entry(work_item(group, groups), thread);
    let index = entry.index;
    let face = entry.face;
    let normal = entry.normal;
    colors[thread] = vec4(0.0);
    if (thread < point_count(entry.exposed)) {
        let level = level_of_index(index);
        let point = vec3<f32>(voxel_of_index(index))
            + surface_point(entry.exposed, entry.plane, normal, thread);
        let size = level_voxel_size(level);
        colors[thread] = color_at(level_corner(level) + size * point, normal, size);
    }
    workgroupBarrier();
    if (thread > 0u) {
        return;
    }
    var sum = vec4(0.0);
    for (var i = 0u; i < THREADS; i++) {
        sum += colors[i];
    }
    if (sum.a == 0.0) {
        return;
    }
    let key = face_key(index, face);
    let packed = pack_seen(sum.rgb / sum.a, seen_tag(key));
    for (var f = face; f < FACES; f++) {
        if (face_key(index, f) == key) {
            seen[FACES * index + f] = packed;
        }
    }
}

// Lists what there is to do: the surfaces, and the voxels without. Faces of occupied voxels without
// a surface lose their weight.

#import bevy_voxel_gi::atlas::atlas_texel
#import bevy_voxel_gi::surface::{exposed_in_column, is_first_face, face_key, main_face,
    surface_normal}
#import bevy_voxel_gi::trace::{masks, volume}
#import bevy_voxel_gi::volume::{FACES, voxel_count, voxel_index, voxel_of_index}

// First surfaces, from `air_start` on voxels without.
@group(1) @binding(0) var<storage, read_write> work: array<u32>;
// How many of each.
@group(1) @binding(1) var<storage, read_write> counters: array<atomic<u32>>;
@group(1) @binding(2) var light: texture_storage_3d<rgba16float, write>;
@group(1) @binding(3) var<storage, read_write> irradiance: array<vec4<u32>>;

const FACE_OF_AIR: u32 = 6u;

fn is_occupied(index: u32) -> bool {
    return (masks[2u * index] | masks[2u * index + 1u]) != 0u;
}

// Whether one of the 26 voxels around has a surface.
fn is_near_surface(index: u32) -> bool {
    let voxel = vec3<i32>(voxel_of_index(volume, index));
    let last = vec3(i32(volume.resolution) - 1);
    for (var i = 0; i < 27; i++) {
        let neighbor = clamp(voxel + vec3(i % 3, (i / 3) % 3, i / 9) - 1, vec3(0), last);
        if (is_occupied(voxel_index(volume, index / voxel_count(volume), vec3<u32>(neighbor)))) {
            return true;
        }
    }
    return false;
}

fn has_points(index: u32, face: u32) -> bool {
    let towards = main_face(surface_normal(index, face));
    for (var column = 0u; column < 16u; column++) {
        if (exposed_in_column(index, towards, column) < 64u) {
            return true;
        }
    }
    return false;
}

@compute @workgroup_size(64)
fn list(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
) {
    let index = id.x + id.y * groups.x * 64u;
    let count = volume.cascades * voxel_count(volume);
    if (index >= count) {
        return;
    }
    if (!is_occupied(index)) {
        let turn = (index + volume.frame) % volume.air_interval == 0u;
        if (turn || volume.blend == 1.0 || is_near_surface(index)) {
            let place = atomicAdd(&counters[1], 1u);
            work[FACES * count + place] = 8u * index + FACE_OF_AIR;
        }
        return;
    }
    for (var face = 0u; face < FACES; face++) {
        let known = face_key(index, face) != 0u && has_points(index, face);
        if (!known) {
            textureStore(light, atlas_texel(volume, index, face), vec4(0.0));
#ifndef OCCLUSION_ONLY
            irradiance[FACES * index + face] = vec4(0u);
#endif
        } else if (is_first_face(index, face)) {
            let place = atomicAdd(&counters[0], 1u);
            work[place] = 8u * index + face;
        }
    }
}

// The sizes of the dispatches over both lists, one workgroup an entry.
@compute @workgroup_size(1)
fn finish() {
    for (var i = 0u; i < 2u; i++) {
        let count = atomicLoad(&counters[i]);
        let x = clamp(count, 1u, 32768u);
        atomicStore(&counters[4u + 4u * i], select(x, 0u, count == 0u));
        atomicStore(&counters[5u + 4u * i], (count + x - 1u) / x);
        atomicStore(&counters[6u + 4u * i], 1u);
    }
}

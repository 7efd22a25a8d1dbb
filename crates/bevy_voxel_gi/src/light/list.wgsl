// Lists what there is to do: the surfaces, and the voxels without. Faces of occupied voxels without
// a surface lose their weight.

#import bevy_voxel_gi::atlas::{atlas_texel, mask_texel, pack_word}
#import bevy_voxel_gi::faces::{exposed_in_column, face_key, masks, surface_normal}
#import bevy_voxel_gi::surface::{is_first_face, main_face}
#import bevy_voxel_gi::volume::{FACES, FLAG_WEIGHTED, is_due, volume, voxel_count}

// First surfaces, from `air_start` on voxels without.
@group(1) @binding(0) var<storage, read_write> work: array<u32>;
// How many of each.
@group(1) @binding(1) var<storage, read_write> counters: array<atomic<u32>>;
@group(1) @binding(2) var light: texture_storage_3d<rgba16float, write>;
@group(1) @binding(3) var<storage, read_write> irradiance: array<vec4<u32>>;

const FACE_OF_AIR: u32 = 6u;

fn is_occupied(index: u32) -> bool {
    return any(masks[index] != vec2(0u));
}

// Forgets the light of surfaces that are gone. Whether there was any: what pixels read is still that.
fn forget(index: u32) -> bool {
    var known = false;
#ifndef OCCLUSION_ONLY
    for (var face = 0u; face < FACES; face++) {
        // The weight is in the last word.
        if (irradiance[FACES * index + face].w != 0u) {
            irradiance[FACES * index + face] = vec4(0u);
            known = true;
        }
    }
#endif
    return known;
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
    let count = volume.level_count * voxel_count();
    if (index >= count) {
        return;
    }
#ifdef PER_PIXEL
    for (var half = 0u; half < 2u; half++) {
        textureStore(light, mask_texel(index, half), pack_word(masks[index][half]));
    }
#endif
    if (!is_occupied(index)) {
        let turn = (index + volume.round) % volume.air_interval == 0u;
        if (is_due(index) && (forget(index) || turn || volume.blend == 1.0)) {
            let place = atomicAdd(&counters[1], 1u);
            work[FACES * count + place] = 8u * index + FACE_OF_AIR;
        }
        return;
    }
    for (var face = 0u; face < FACES; face++) {
        let known = face_key(index, face) != 0u && has_points(index, face);
        if (!known) {
            textureStore(light, atlas_texel(index, face), vec4(0.0));
#ifndef OCCLUSION_ONLY
            irradiance[FACES * index + face] = vec4(0u);
#endif
        } else if (is_first_face(index, face)) {
            let place = atomicAdd(&counters[0], 1u);
            work[place] = 8u * index + face;
        }
    }
}

// A number for the receiver.
fn tell(place: u32, number: f32) {
    let r = volume.resolution;
    let slice = textureDimensions(light).z - 1u;
    textureStore(light, vec3(place % r, place / r, slice), pack_word(bitcast<u32>(number)));
}

// Where the levels are, in step with `receive.wgsl`.
fn tell_levels() {
    let extent = volume.extent;
    tell(0u, f32(volume.level_count));
    tell(1u, extent.x);
    tell(2u, extent.y);
    tell(3u, extent.z);
    for (var i = 0u; i < volume.level_count; i++) {
        let corner = volume.levels[i].corner - volume.center;
        let start = 4u + 5u * i;
        tell(start, corner.x);
        tell(start + 1u, corner.y);
        tell(start + 2u, corner.z);
        tell(start + 3u, volume.levels[i].voxel_size);
        tell(start + 4u, volume.levels[i].intensity);
    }
}

// The sizes of the dispatches over both lists, one workgroup an entry; and what the receiver is told.
@compute @workgroup_size(1)
fn finish() {
    if ((volume.flags & FLAG_WEIGHTED) != 0u) {
        tell_levels();
    }
    for (var i = 0u; i < 2u; i++) {
        let count = atomicLoad(&counters[i]);
        let x = clamp(count, 1u, 32768u);
        atomicStore(&counters[4u + 4u * i], select(x, 0u, count == 0u));
        atomicStore(&counters[5u + 4u * i], (count + x - 1u) / x);
        atomicStore(&counters[6u + 4u * i], 1u);
    }
}

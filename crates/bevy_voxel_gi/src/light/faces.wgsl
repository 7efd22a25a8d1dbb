// The faces of a voxel: what surface stands for each, and at which sub-voxels it shows.

#define_import_path bevy_voxel_gi::faces

#import bevy_voxel_gi::volume::{FACES, FINE, face_normal, face_towards, fine_bit, key_normal,
    level_of_index, volume, voxel_index, voxel_of_index}

// Two words a voxel, a bit for each touched sub-voxel.
@group(0) @binding(1) var<storage, read> masks: array<u32>;
// One a face, 0 without a surface.
@group(0) @binding(2) var<storage, read> keys: array<u32>;

// Normal and material of a key, without its weight; 0 if there is no surface.
fn face_key(index: u32, face: u32) -> u32 {
#ifdef OCCLUSION_ONLY
    // Any six values: each face is a surface of its own.
    return face + 1u;
#else
    let key = keys[FACES * index + face];
    // A material and normal of zero are a surface too: mark its presence.
    return select((key & 0xffffffu) | 0x1000000u, 0u, key == 0u);
#endif
}

fn surface_normal(index: u32, face: u32) -> vec3<f32> {
#ifdef OCCLUSION_ONLY
    return face_normal(face);
#else
    return key_normal(keys[FACES * index + face]);
#endif
}

fn is_set(mask: vec2<u32>, cell: vec3<u32>) -> bool {
    let bit = fine_bit(cell);
    return (select(mask.x, mask.y, bit >= 32u) & (1u << (bit & 31u))) != 0u;
}

// The bit of the outermost sub-voxel of one of 16 columns towards a face, if the column is free in
// front of the voxel; 64 if there is none.
fn exposed_in_column(index: u32, face: u32, column: u32) -> u32 {
    let mask = vec2(masks[2u * index], masks[2u * index + 1u]);
    let axis = face >> 1u;
    let backward = (face & 1u) == 1u;
    var cell: vec3<u32>;
    cell[(axis + 1u) % 3u] = column % FINE;
    cell[(axis + 2u) % 3u] = column / FINE;
    let voxel = voxel_of_index(index);
    let at_border = voxel[axis] == select(volume.resolution - 1u, 0u, backward);
    if (!at_border) {
        var neighbor = voxel;
        neighbor[axis] = select(voxel[axis] + 1u, voxel[axis] - 1u, backward);
        let beyond = voxel_index(level_of_index(index), neighbor);
        cell[axis] = select(0u, FINE - 1u, backward);
        if (is_set(vec2(masks[2u * beyond], masks[2u * beyond + 1u]), cell)) {
            return 64u;
        }
    }
    for (var depth = 0u; depth < FINE; depth++) {
        cell[axis] = select(FINE - 1u - depth, depth, backward);
        if (is_set(mask, cell)) {
            return fine_bit(cell);
        }
    }
    return 64u;
}

// Whether the surface of a face of the voxel in which a ray ends is turned to the ray. `hit` is 64
// times the index of the voxel, plus the bit of the sub-voxel.
fn is_turned(hit: u32, direction: vec3<f32>, axis: u32) -> bool {
    let index = hit / 64u;
    let face = face_towards(axis, -direction[axis]);
    return face_key(index, face) != 0u && dot(direction, surface_normal(index, face)) < 0.0;
}

// Whether the sub-voxel is the outermost towards that face.
fn is_outermost(hit: u32, direction: vec3<f32>, axis: u32) -> bool {
    let cell = vec3(hit % FINE, (hit / FINE) % FINE, (hit / (FINE * FINE)) % FINE);
    let column = cell[(axis + 1u) % 3u] + FINE * cell[(axis + 2u) % 3u];
    return exposed_in_column(hit / 64u, face_towards(axis, -direction[axis]), column) == hit % 64u;
}

// Whether the face shows where the ray ends. Without the second rule the outside of a thin wall
// would be seen from within.
fn shows(hit: u32, direction: vec3<f32>, axis: u32) -> bool {
    return is_turned(hit, direction, axis) && is_outermost(hit, direction, axis);
}

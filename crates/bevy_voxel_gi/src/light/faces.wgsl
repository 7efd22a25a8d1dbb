// The faces of a voxel: what surface stands for each, and at which sub-voxels it shows.

#define_import_path bevy_voxel_gi::faces

#import bevy_voxel_gi::volume::{FACES, FINE, face_normal, face_towards, fine_bit, key_normal,
    level_of_index, volume, voxel_index, voxel_of_index}

// A bit for each touched sub-voxel.
@group(0) @binding(1) var<storage, read> masks: array<vec2<u32>>;
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

// 0 if there is no surface.
fn surface_normal(index: u32, face: u32) -> vec3<f32> {
#ifdef OCCLUSION_ONLY
    return face_normal(face);
#else
    let key = keys[FACES * index + face];
    return select(key_normal(key), vec3(0.0), key == 0u);
#endif
}

fn is_set(mask: vec2<u32>, bit: u32) -> bool {
    return (select(mask.x, mask.y, bit >= 32u) & (1u << (bit & 31u))) != 0u;
}

// The four sub-voxels in line with one along an axis, a bit each, the lowest coordinate first.
fn column_bits(mask: vec2<u32>, axis: u32, cell: vec3<u32>) -> u32 {
    let layer = select(mask.x, mask.y, cell.z >= 2u) >> (16u * (cell.z & 1u));
    let along_x = layer >> (FINE * cell.y);
    let in_y = (layer >> cell.x) & 0x1111u;
    let along_y = in_y | (in_y >> 3u) | (in_y >> 6u) | (in_y >> 9u);
    let in_z = (mask >> vec2(cell.x + FINE * cell.y)) & vec2(0x10001u);
    let pairs = in_z | (in_z >> vec2(15u));
    let along_z = (pairs.x & 3u) | ((pairs.y & 3u) << 2u);
    return select(select(along_z, along_y, axis == 1u), along_x, axis == 0u) & 15u;
}

// Whether a touched sub-voxel is the outermost of its voxel towards a face, and free in front.
fn is_outermost(level: u32, voxel: vec3<u32>, mask: vec2<u32>, cell: vec3<u32>, face: u32) -> bool {
    let axis = face >> 1u;
    let backward = (face & 1u) == 1u;
    let column = column_bits(mask, axis, cell);
    let beyond = select(column >> (cell[axis] + 1u), column & ((1u << cell[axis]) - 1u), backward);
    if (beyond != 0u) {
        return false;
    }
    if (voxel[axis] == select(volume.resolution - 1u, 0u, backward)) {
        return true;
    }
    var neighbor = voxel;
    neighbor[axis] = select(voxel[axis] + 1u, voxel[axis] - 1u, backward);
    var next = cell;
    next[axis] = select(0u, FINE - 1u, backward);
    return !is_set(masks[voxel_index(level, neighbor)], fine_bit(next));
}

// The bit of the outermost sub-voxel of one of 16 columns towards a face, if the column is free in
// front of the voxel; 64 if there is none.
fn exposed_in_column(index: u32, face: u32, column: u32) -> u32 {
    let mask = masks[index];
    let axis = face >> 1u;
    var cell: vec3<u32>;
    cell[(axis + 1u) % 3u] = column % FINE;
    cell[(axis + 2u) % 3u] = column / FINE;
    let bits = column_bits(mask, axis, cell);
    if (bits == 0u) {
        return 64u;
    }
    cell[axis] = select(firstLeadingBit(bits), firstTrailingBit(bits), (face & 1u) == 1u);
    let exposed = is_outermost(level_of_index(index), voxel_of_index(index), mask, cell, face);
    return select(64u, fine_bit(cell), exposed);
}

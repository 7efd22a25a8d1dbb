// Where a face of a voxel is in the texture that Bevy samples: as in Bevy's irradiance volumes,
// positive faces in the lower half of y, axes one behind the other along z, and levels behind
// those. Then, for receivers that look for the voxels around them, which sub-voxels are touched, and
// last a slice that says where the levels are.

#define_import_path bevy_voxel_gi::atlas

#import bevy_voxel_gi::volume::{level_of_index, volume, voxel_of_index}

fn atlas_texel(index: u32, face: u32) -> vec3<i32> {
    let r = volume.resolution;
    let slab = 3u * level_of_index(index) + (face >> 1u);
    let corner = vec3(0u, (face & 1u) * r, slab * r);
    return vec3<i32>(voxel_of_index(index) + corner);
}

// Half of a voxel's 64 sub-voxels, in the bytes of `pack_word`.
fn mask_texel(index: u32, half: u32) -> vec3<i32> {
    let r = volume.resolution;
    let slab = 3u * volume.level_count + level_of_index(index);
    return vec3<i32>(voxel_of_index(index) + vec3(0u, half * r, slab * r));
}

// 32 bits as four whole numbers that a 16-bit float holds exactly.
fn pack_word(word: u32) -> vec4<f32> {
    return vec4<f32>((vec4(word) >> vec4(0u, 8u, 16u, 24u)) & vec4(255u));
}

// The nearest number that a 16-bit float can be: some devices would cut the rest off instead, and a
// mean over frames would sink.
fn rounded(light: vec4<f32>) -> vec4<f32> {
    return bitcast<vec4<f32>>((bitcast<vec4<u32>>(light) + 0x1000u) & vec4(0xffffe000u));
}

fn pack_light(light: vec4<f32>) -> vec2<u32> {
    let exact = min(rounded(light), vec4(65504.0));
    return vec2(pack2x16float(exact.rg), pack2x16float(exact.ba));
}

fn unpack_light(words: vec2<u32>) -> vec4<f32> {
    return vec4(unpack2x16float(words.x), unpack2x16float(words.y));
}

// What 16-bit floats hold.
fn storable(light: vec3<f32>) -> vec3<f32> {
    return clamp(light, vec3(0.0), vec3(65504.0));
}

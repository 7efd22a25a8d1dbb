// Where a face of a voxel is in the texture that Bevy samples: as in Bevy's irradiance volumes,
// positive faces in the lower half of y, axes one behind the other along z, and cascades behind
// those.

#define_import_path bevy_voxel_gi::atlas

#import bevy_voxel_gi::volume::{Volume, voxel_count, voxel_of_index}

fn atlas_texel(volume: Volume, index: u32, face: u32) -> vec3<i32> {
    let r = volume.resolution;
    let cascade = index / voxel_count(volume);
    let corner = vec3(0u, (face & 1u) * r, (3u * cascade + (face >> 1u)) * r);
    return vec3<i32>(voxel_of_index(volume, index) + corner);
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

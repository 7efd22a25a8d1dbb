// The albedo of a surface: as a camera has seen it, where one has, or that of its material.

#define_import_path bevy_voxel_gi::albedo

#import bevy_voxel_gi::faces::face_key
#import bevy_voxel_gi::volume::FACES

#ifdef SEEN_ALBEDO
@group(0) @binding(3) var<storage, read> seen_albedo: array<u32>;
#endif

// 8 bits of a surface's key, never 0: what was seen counts as long as they are the same.
fn seen_tag(key: u32) -> u32 {
    return 1u + ((key * 2654435761u) >> 24u) % 255u;
}

// 8 bits a channel, finer in the dark, and the tag.
fn pack_seen(albedo: vec3<f32>, tag: u32) -> u32 {
    return pack4x8unorm(vec4(pow(albedo, vec3(1.0 / 2.2)), 0.0)) | (tag << 24u);
}

fn surface_albedo(index: u32, face: u32, of_material: vec3<f32>) -> vec3<f32> {
#ifdef SEEN_ALBEDO
    let word = seen_albedo[FACES * index + face];
    if (word >> 24u == seen_tag(face_key(index, face))) {
        return pow(unpack4x8unorm(word).rgb, vec3(2.2));
    }
#endif
    return of_material;
}

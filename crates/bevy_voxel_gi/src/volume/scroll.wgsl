// Light that was known follows the volume as it moves by whole voxels.

#import bevy_voxel_gi::volume::{FACES, Volume, voxel_count, voxel_index, voxel_of_index}

struct Scroll {
    // By how many voxels of the smallest cascade the volume has moved.
    voxels: vec3<i32>,
    pad: u32,
}

@group(0) @binding(0) var<uniform> volume: Volume;
@group(0) @binding(1) var<uniform> moved: Scroll;
@group(0) @binding(2) var<storage, read> before: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read_write> after: array<vec4<u32>>;

@compute @workgroup_size(64)
fn scroll(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
) {
    let index = id.x + id.y * groups.x * 64u;
    if (index >= volume.cascades * voxel_count(volume)) {
        return;
    }
    let cascade = index / voxel_count(volume);
    let source = vec3<i32>(voxel_of_index(volume, index)) + moved.voxels / i32(1u << cascade);
    let inside = all(source >= vec3(0)) && all(source < vec3(i32(volume.resolution)));
    for (var face = 0u; face < FACES; face++) {
        var light = vec4(0u);
        if (inside) {
            light = before[FACES * voxel_index(volume, cascade, vec3<u32>(source)) + face];
        }
        after[FACES * index + face] = light;
    }
}

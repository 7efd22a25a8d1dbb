// Light that was known follows the levels as they move by whole voxels.

#import bevy_voxel_gi::volume::{FACES, level_of_index, volume, voxel_count, voxel_index,
    voxel_of_index}

// By how many of its voxels each level has moved.
@group(0) @binding(1) var<uniform> moved: array<vec4<i32>, 8>;
@group(0) @binding(2) var<storage, read> before: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read_write> after: array<vec4<u32>>;

@compute @workgroup_size(64)
fn scroll(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
) {
    let index = id.x + id.y * groups.x * 64u;
    if (index >= volume.level_count * voxel_count()) {
        return;
    }
    let level = level_of_index(index);
    let source = vec3<i32>(voxel_of_index(index)) + moved[level].xyz;
    let inside = all(source >= vec3(0)) && all(source < vec3(i32(volume.resolution)));
    for (var face = 0u; face < FACES; face++) {
        var light = vec4(0u);
        if (inside) {
            light = before[FACES * voxel_index(level, vec3<u32>(source)) + face];
        }
        after[FACES * index + face] = light;
    }
}

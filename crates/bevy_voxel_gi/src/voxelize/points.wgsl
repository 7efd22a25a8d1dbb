// Stochastic voxelisation (thesis section 6.4.3): random points on each triangle (G. Turk,
// "Generating Random Points in Triangles", 1990), the same in every frame. A voxel with a point
// is solid as a whole, as a sparse set of sub-voxels would let light through.

#import bevy_voxel_gi::volume::{FINE, volume}
#import bevy_voxel_gi::triangles::{
    Batch, Instance, Triangle, batches, instances, load_triangle, mark,
}

// M. Jarzynski and M. Olano, "Hash Functions for GPU Rendering", 2020: pcg3d.
fn random(key: vec3<u32>) -> vec2<f32> {
    var v = key * 1664525u + 1013904223u;
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v ^= v >> vec3(16u);
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    return vec2<f32>(v.xy >> vec2(8u)) / 16777216.0;
}

@compute @workgroup_size(64)
fn voxelize(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let batch = batches[min(group.x + group.y * groups.x, arrayLength(&batches) - 1u)];
    let instance = instances[batch.instance];
    let triangle = load_triangle(batch, instance, thread);
    if (all(triangle.normal == vec3(0.0))) {
        return;
    }
    let extent = f32(volume.resolution * FINE);
    for (var i = 0u; i < volume.points_per_triangle; i++) {
        let r = random(vec3(batch.instance, batch.first_triangle + thread, i));
        let root = sqrt(r.x);
        let point = (1.0 - root) * triangle.a + (1.0 - r.y) * root * triangle.b
            + r.y * root * triangle.c;
        if (all(point >= vec3(0.0)) && all(point < vec3(extent))) {
            let voxel = vec3<u32>(point) / FINE;
            mark(batch, instance, voxel, vec2(0xffffffffu), triangle.normal);
        }
    }
}

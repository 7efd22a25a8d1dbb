// The slicing voxelisers of the thesis (section 6.4.2), with threads in the place of the geometry
// shader: a triangle is drawn into every slice that it spans, sampled at the centres of columns of
// sub-voxels. With `GEOMETRY_CLIPPING` it is cut to the slice first and only the piece is
// rasterised; without (fragment clipping) all of it is and what lies in other slices is dropped.
// The voxels are the same, the cost is not. Projection is along the axis of the triangle's greatest
// extent, which replaces the thesis's three passes.

#import bevy_voxel_gi::volume::{FINE, fine_bit, volume}
#import bevy_voxel_gi::triangles::{
    Batch, Instance, Triangle, batches, instances, load_triangle, main_axis, mark,
    turned, turned_back,
}

struct Bounds {
    low: vec2<f32>,
    high: vec2<f32>,
}

// Where the piece of a triangle between two depths lies in the plane.
fn piece(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>, near: f32, far: f32) -> Bounds {
    var bounds = Bounds(vec2(3e38), vec2(-3e38));
    var corners = array(a, b, c);
    for (var i = 0u; i < 3u; i++) {
        let p = corners[i];
        let q = corners[(i + 1u) % 3u];
        if (p.z >= near && p.z <= far) {
            bounds = Bounds(min(bounds.low, p.xy), max(bounds.high, p.xy));
        }
        for (var side = 0u; side < 2u; side++) {
            let depth = select(near, far, side == 1u);
            if ((p.z < depth) != (q.z < depth)) {
                let cut = mix(p.xy, q.xy, (depth - p.z) / (q.z - p.z));
                bounds = Bounds(min(bounds.low, cut), max(bounds.high, cut));
            }
        }
    }
    return bounds;
}

fn inside(p: vec2<f32>, a: vec2<f32>, b: vec2<f32>, c: vec2<f32>, winding: f32) -> bool {
    let ab = winding * vec2(a.y - b.y, b.x - a.x);
    let bc = winding * vec2(b.y - c.y, c.x - b.x);
    let ca = winding * vec2(c.y - a.y, a.x - c.x);
    return dot(ab, p - a) >= 0.0 && dot(bc, p - b) >= 0.0 && dot(ca, p - c) >= 0.0;
}

fn draw(batch: Batch, instance: Instance, triangle: Triangle) {
    if (all(triangle.normal == vec3(0.0))) {
        return;
    }
    let axis = main_axis(triangle.normal);
    let a = turned(triangle.a, axis);
    let b = turned(triangle.b, axis);
    let c = turned(triangle.c, axis);
    let low = min(a, min(b, c));
    let high = max(a, max(b, c));
    let extent = f32(volume.resolution * FINE);
    if (any(high < vec3(0.0)) || any(low >= vec3(extent))) {
        return;
    }
    let normal = cross(b - a, c - a);
    let slope = -normal.xy / normal.z;
    let winding = select(-1.0, 1.0, normal.z >= 0.0);
    let first = u32(max(floor(low.z), 0.0));
    let last = u32(clamp(floor(high.z), 0.0, extent - 1.0));
    for (var slice = first; slice <= last; slice++) {
        var bounds = Bounds(low.xy, high.xy);
#ifdef GEOMETRY_CLIPPING
        bounds = piece(a, b, c, f32(slice), f32(slice + 1u));
#endif
        let begin = vec2<u32>(clamp(floor(bounds.low), vec2(0.0), vec2(extent)));
        let end = vec2<u32>(clamp(ceil(bounds.high), vec2(0.0), vec2(extent)));
        for (var v = begin.y; v < end.y; v++) {
            for (var u = begin.x; u < end.x; u++) {
                let center = vec2(f32(u), f32(v)) + 0.5;
                let depth = a.z + dot(slope, center - a.xy);
                if (floor(depth) == f32(slice) && inside(center, a.xy, b.xy, c.xy, winding)) {
                    let cell = turned_back(vec3(u, v, slice), axis);
                    let bit = fine_bit(cell % FINE);
                    var mask = vec2(0u);
                    mask[bit >> 5u] = 1u << (bit & 31u);
                    mark(batch, instance, cell / FINE, mask, triangle.normal);
                }
            }
        }
    }
}

@compute @workgroup_size(64)
fn voxelize(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let batch = batches[min(group.x + group.y * groups.x, arrayLength(&batches) - 1u)];
    let instance = instances[batch.instance];
    draw(batch, instance, load_triangle(batch, instance, thread));
}

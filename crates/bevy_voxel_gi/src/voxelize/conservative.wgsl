// Every sub-voxel that a triangle touches (M. Schwarz and H.-P. Seidel, "Fast Parallel Surface
// and Solid Voxelization on GPUs", 2010): the plane test along the axis of the greatest projection
// and three 2D tests. The columns of voxels under up to 64 triangles are dealt out evenly to the
// 64 threads, so that neither one huge triangle nor many small ones leave threads idle.

#import bevy_voxel_gi::volume::{FINE, fine_bit, volume}
#import bevy_voxel_gi::triangles::{
    Batch, Instance, SINK, Triangle, batches, instances, load_triangle, main_axis, mark,
    turned, turned_back,
}

struct Prepared {
    triangle: Triangle,
    // Projected along this axis.
    axis: u32,
    // First column of voxels and how many there are along both other axes.
    first: vec2<u32>,
    size: vec2<u32>,
}

var<workgroup> prepared: array<Prepared, 64>;
// Columns of all triangles up to and with this one.
var<workgroup> columns: array<u32, 64>;

struct Bounds {
    low: vec3<f32>,
    high: vec3<f32>,
}

// Of a triangle, less a little (`SINK`).
fn bounds_of(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> Bounds {
    let low = min(a, min(b, c));
    let high = max(a, max(b, c));
    let less = min(vec3(SINK * f32(FINE)), 0.25 * (high - low));
    return Bounds(low + less, high - less);
}

fn prepare(triangle: Triangle) -> Prepared {
    var result: Prepared;
    result.triangle = triangle;
    if (all(triangle.normal == vec3(0.0))) {
        return result;
    }
    result.axis = main_axis(triangle.normal);
    let a = turned(triangle.a, result.axis);
    let b = turned(triangle.b, result.axis);
    let c = turned(triangle.c, result.axis);
    let bounds = bounds_of(a, b, c);
    let low = bounds.low;
    let high = bounds.high;
    let extent = f32(volume.resolution * FINE);
    if (any(high < vec3(0.0)) || any(low > vec3(extent))) {
        return result;
    }
    let last = f32(volume.resolution) - 1.0;
    let first = clamp(floor(low.xy / f32(FINE)), vec2(0.0), vec2(last));
    let end = clamp(last_cell(low.xy / f32(FINE), high.xy / f32(FINE)), vec2(0.0), vec2(last));
    result.first = vec2<u32>(first);
    result.size = vec2<u32>(end - first + 1.0);
    return result;
}

// The last cell of an interval: one that it only touches from below does not count.
fn last_cell(low: vec2<f32>, high: vec2<f32>) -> vec2<f32> {
    return max(ceil(high) - 1.0, floor(low));
}

// Whether the unit square at `corner` and a triangle overlap as far as its edges tell.
fn overlaps(corner: vec2<f32>, a: vec2<f32>, b: vec2<f32>, c: vec2<f32>, winding: f32) -> bool {
    return beyond(corner, a, b, winding) && beyond(corner, b, c, winding)
        && beyond(corner, c, a, winding);
}

// Whether any of the unit square is on the inner side of an edge.
fn beyond(corner: vec2<f32>, a: vec2<f32>, b: vec2<f32>, winding: f32) -> bool {
    let inward = winding * vec2(a.y - b.y, b.x - a.x);
    return dot(inward, corner - a) + max(inward.x, 0.0) + max(inward.y, 0.0) >= 0.0;
}

fn column(batch: Batch, instance: Instance, p: Prepared, number: u32) {
    let place = p.first + vec2(number % p.size.x, number / p.size.x);
    let a = turned(p.triangle.a, p.axis);
    let b = turned(p.triangle.b, p.axis);
    let c = turned(p.triangle.c, p.axis);
    let geometric = cross(b - a, c - a);
    let winding = select(vec3(-1.0), vec3(1.0), geometric >= vec3(0.0));
    let bounds = bounds_of(a, b, c);
    let low = bounds.low;
    let high = bounds.high;
    // Depth along the column: depth at the origin plus slope times place.
    let slope = -geometric.xy / geometric.z;
    let low_slope = min(slope, vec2(0.0));
    let high_slope = max(slope, vec2(0.0));
    let corner = vec2<f32>(place * FINE);
    let at_corner = a.z + dot(slope, corner - a.xy);
    let fine = f32(FINE);
    let near = max(at_corner + fine * (low_slope.x + low_slope.y), low.z);
    let far = min(at_corner + fine * (high_slope.x + high_slope.y), high.z);
    if (far < near || far < 0.0) {
        return;
    }
    let first = u32(max(floor(near / fine), 0.0));
    let last = min(u32(max(ceil(far / fine) - 1.0, floor(near / fine))), volume.resolution - 1u);
    for (var layer = first; layer <= last && layer < volume.resolution; layer++) {
        var mask = vec2(0u);
        for (var i = 0u; i < FINE * FINE; i++) {
            let offset = vec2(i % FINE, i / FINE);
            let cell = corner + vec2<f32>(offset);
            if (any(cell + 1.0 <= low.xy) || any(cell >= high.xy)
                || !overlaps(cell, a.xy, b.xy, c.xy, winding.z)) {
                continue;
            }
            let depth = a.z + dot(slope, cell - a.xy);
            let begin = max(depth + low_slope.x + low_slope.y, low.z);
            let end = min(depth + high_slope.x + high_slope.y, high.z);
            let bottom = f32(layer * FINE);
            let from_ = max(floor(begin) - bottom, 0.0);
            let to = min(max(ceil(end) - 1.0, floor(begin)) - bottom, fine - 1.0);
            for (var d = from_; d <= to; d += 1.0) {
                let deep = bottom + d;
                if (overlaps(vec2(cell.y, deep), a.yz, b.yz, c.yz, winding.x)
                    && overlaps(vec2(deep, cell.x), a.zx, b.zx, c.zx, winding.y)) {
                    let bit = fine_bit(turned_back(vec3(offset, u32(d)), p.axis));
                    mask[bit >> 5u] |= 1u << (bit & 31u);
                }
            }
        }
        if (any(mask != vec2(0u))) {
            let voxel = turned_back(vec3(place, layer), p.axis);
            mark(batch, instance, voxel, mask, p.triangle.normal);
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
    let mine = prepare(load_triangle(batch, instance, thread));
    prepared[thread] = mine;
    columns[thread] = mine.size.x * mine.size.y;
    workgroupBarrier();
    for (var step = 1u; step < 64u; step *= 2u) {
        var before = 0u;
        if (thread >= step) {
            before = columns[thread - step];
        }
        workgroupBarrier();
        columns[thread] += before;
        workgroupBarrier();
    }
    let total = columns[63];
    for (var item = thread; item < total; item += 64u) {
        // The first triangle whose columns end after this one.
        var owner = 0u;
        for (var step = 32u; step > 0u; step /= 2u) {
            if (columns[owner + step - 1u] <= item) {
                owner += step;
            }
        }
        let p = prepared[owner];
        column(batch, instance, p, item - (columns[owner] - p.size.x * p.size.y));
    }
}

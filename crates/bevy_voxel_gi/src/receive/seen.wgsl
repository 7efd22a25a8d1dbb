// The higher-quality receiver: of the eight voxels around a pixel those count that it sees, by a
// short ray along its surface through the sub-voxels. `Field::irradiance_seen` in
// `reference/field.rs` step by step.

#define_import_path bevy_voxel_gi::seen

const FINE: i32 = 4;
// Weight of a voxel that is not seen: it counts where no other does.
const HIDDEN: f32 = 0.0009765625;
// How far in front of the sub-voxels that a surface fills it looks around.
const CLEARANCE: f32 = 0.00390625;
// Steps towards the viewer out of a sub-voxel that something else fills as well, and their length
// in voxels.
const ESCAPE_STEPS: u32 = 3u;
const ESCAPE: f32 = 0.125;

// Whether a sub-voxel, counted from the level's corner, is touched. Outside none is.
fn is_touched(light: texture_3d<f32>, slab: i32, cell: vec3<i32>) -> bool {
    let resolution = i32(textureDimensions(light).x);
    if (any(cell < vec3(0)) || any(cell >= vec3(FINE * resolution))) {
        return false;
    }
    let voxel = cell / FINE;
    let fine = cell % FINE;
    let bit = u32(fine.x + FINE * (fine.y + FINE * fine.z));
    let half = select(0, resolution, bit >= 32u);
    let bytes = textureLoad(light, voxel + vec3(0, half, slab * resolution), 0);
    let byte = u32(bytes[(bit >> 3u) & 3u]);
    return (byte & (1u << (bit & 7u))) != 0u;
}

// Whether no sub-voxel is touched from one place to another, in sub-voxels. They are near.
fn is_clear(light: texture_3d<f32>, slab: i32, start: vec3<f32>, way: vec3<f32>) -> bool {
    let ray = select(way, vec3(1e-6), abs(way) < vec3(1e-6));
    let step = select(vec3(-1), vec3(1), ray > vec3(0.0));
    var cell = vec3<i32>(floor(start));
    // Where the ray enters the next cell along each axis, from 0 to 1 over the way.
    var next = (floor(start) + select(vec3(0.0), vec3(1.0), ray > vec3(0.0)) - start) / ray;
    let per_cell = abs(1.0 / ray);
    // Half a voxel's diagonal twice, in sub-voxels, along three axes.
    for (var i = 0u; i < 24u; i++) {
        if (is_touched(light, slab, cell)) {
            return false;
        }
        let first = min(next.x, min(next.y, next.z));
        if (first >= 1.0) {
            return true;
        }
        if (first == next.x) {
            cell.x += step.x;
            next.x += per_cell.x;
        } else if (first == next.y) {
            cell.y += step.y;
            next.y += per_cell.y;
        } else {
            cell.z += step.z;
            next.z += per_cell.z;
        }
    }
    return true;
}

// Light times weight, and weight; `position` is in voxels from the corner of the level.
fn seen_light(light: texture_3d<f32>, level: u32, levels: u32, position: vec3<f32>,
    normal: vec3<f32>, to_viewer: vec3<f32>) -> vec4<f32> {
    let resolution = i32(textureDimensions(light).x);
    let slab = i32(3u * levels + level);
    let fine = f32(FINE);
    let reach = abs(normal.x) + abs(normal.y) + abs(normal.z);
    var eye = position + normal * (reach / fine + CLEARANCE);
    for (var i = 0u; i < ESCAPE_STEPS; i++) {
        if (is_touched(light, slab, vec3<i32>(floor(eye * fine)))) {
            eye += to_viewer * ESCAPE;
        }
    }
    let is_lost = is_touched(light, slab, vec3<i32>(floor(eye * fine)));
    let place = clamp(position, vec3(0.5), vec3(f32(resolution) - 0.5)) - 0.5;
    let low = floor(place);
    let part = place - low;
    var sum = vec4(0.0);
    for (var corner = 0; corner < 8; corner++) {
        let step = vec3(corner & 1, (corner >> 1u) & 1, corner >> 2u);
        let weights = select(1.0 - part, part, step == vec3(1));
        var weight = weights.x * weights.y * weights.z;
        if (weight < 1e-6) {
            continue;
        }
        let voxel = vec3<i32>(low) + step;
        // Along the surface, as far as the middle of the voxel.
        let way = vec3<f32>(voxel) + 0.5 - eye;
        let along = way - normal * dot(normal, way);
        if (!is_lost && !is_clear(light, slab, eye * fine, along * fine)) {
            weight *= HIDDEN;
        }
        for (var axis = 0; axis < 3; axis++) {
            let negative = select(0, resolution, normal[axis] < 0.0);
            let at = voxel + vec3(0, negative, (3 * i32(level) + axis) * resolution);
            sum += textureLoad(light, at, 0) * (normal[axis] * normal[axis] * weight);
        }
    }
    return sum;
}

// The higher-quality receiver: of the eight voxels around a pixel those count that it sees, by a
// short ray along its surface through the sub-voxels. `Field::irradiance_seen` in
// `reference/field.rs` step by step.

#define_import_path bevy_voxel_gi::seen

const FINE: i32 = 4;
// Weight of a voxel that is not seen: it counts where no other does.
const HIDDEN: f32 = 0.0009765625;
// How far in front of the sub-voxels that a surface fills it looks around.
const CLEARANCE: f32 = 0.00390625;
// What is behind so much of touched sub-voxels, in their edges, is hidden; less hides a part of it, so
// that light changes little by little beside small things.
const OPAQUE: f32 = 0.5;
// From a sub-voxel that something else fills as well it looks around from farther towards the viewer,
// but not from farther than this, in voxels.
const FARTHEST: f32 = 0.5;

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

// How far a way leads through touched sub-voxels, in their edges: through all, or only through those
// in which it begins. `start` is in sub-voxels, and near.
fn filled(light: texture_3d<f32>, slab: i32, start: vec3<f32>, way: vec3<f32>, all_: bool) -> f32 {
    let ray = select(way, vec3(1e-6), abs(way) < vec3(1e-6));
    let step = select(vec3(-1), vec3(1), ray > vec3(0.0));
    let ahead = select(vec3(0.0), vec3(1.0), ray > vec3(0.0));
    var cell = vec3<i32>(floor(start));
    var at = 0.0;
    var sum = 0.0;
    // Half a voxel's diagonal twice, in sub-voxels, along three axes.
    for (var i = 0u; i < 24u && at < 1.0; i++) {
        let next = (vec3<f32>(cell) + ahead - start) / ray;
        let first = min(next.x, min(next.y, next.z));
        let end = clamp(first, at, 1.0);
        if (is_touched(light, slab, cell)) {
            sum += end - at;
        } else if (!all_) {
            break;
        }
        at = end;
        if (first == next.x) {
            cell.x += step.x;
        } else if (first == next.y) {
            cell.y += step.y;
        } else {
            cell.z += step.z;
        }
    }
    return sum * length(way);
}

// Light times weight, and weight; `position` is in voxels from the corner of the level.
fn seen_light(light: texture_3d<f32>, level: u32, levels: u32, position: vec3<f32>,
    normal: vec3<f32>, to_viewer: vec3<f32>) -> vec4<f32> {
    let resolution = i32(textureDimensions(light).x);
    let slab = i32(3u * levels + level);
    let fine = f32(FINE);
    let reach = abs(normal.x) + abs(normal.y) + abs(normal.z);
    var eye = position + normal * (reach / fine + CLEARANCE);
    let escape = filled(light, slab, eye * fine, to_viewer * (FARTHEST * fine), false) / fine;
    let clarity = min(2.0 - 2.0 * escape / FARTHEST, 1.0);
    eye += to_viewer * (escape + CLEARANCE);
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
        let through = filled(light, slab, eye * fine, along * fine, true);
        weight *= 1.0 - clarity * min(through / OPAQUE, 1.0 - HIDDEN);
        for (var axis = 0; axis < 3; axis++) {
            let negative = select(0, resolution, normal[axis] < 0.0);
            let at = voxel + vec3(0, negative, (3 * i32(level) + axis) * resolution);
            sum += textureLoad(light, at, 0) * (normal[axis] * normal[axis] * weight);
        }
    }
    return sum;
}

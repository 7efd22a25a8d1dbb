// The surfaces in a voxel: which faces they stand for, and the points from which light is
// gathered, in `reference/surface.rs` step by step.

#define_import_path bevy_voxel_gi::surface

#import bevy_voxel_gi::volume::{FACES, FINE, face_normal, face_towards, fine_bit, key_normal,
    level_of_index, volume, voxel_index, voxel_of_index}
#import bevy_voxel_gi::trace::{NOTHING, keys, masks, trace, travelled}

// Normal and material of a key, without its weight; 0 if there is no surface.
fn face_key(index: u32, face: u32) -> u32 {
#ifdef OCCLUSION_ONLY
    // Any six values: each face is a surface of its own.
    return face + 1u;
#else
    let key = keys[FACES * index + face];
    // A material and normal of zero are a surface too: mark its presence.
    return select((key & 0xffffffu) | 0x1000000u, 0u, key == 0u);
#endif
}

fn surface_normal(index: u32, face: u32) -> vec3<f32> {
#ifdef OCCLUSION_ONLY
    return face_normal(face);
#else
    return key_normal(keys[FACES * index + face]);
#endif
}

// Whether this is the first of the faces that its surface stands for.
fn is_first_face(index: u32, face: u32) -> bool {
    let key = face_key(index, face);
    var first = key != 0u;
    for (var f = 0u; f < face; f++) {
        first = first && face_key(index, f) != key;
    }
    return first;
}

// The face a direction points to most.
fn main_face(direction: vec3<f32>) -> u32 {
    let size = abs(direction);
    let axis = select(select(2u, 1u, size.y >= size.z), 0u, size.x >= size.y && size.x >= size.z);
    return face_towards(axis, direction[axis]);
}

fn is_set(mask: vec2<u32>, cell: vec3<u32>) -> bool {
    let bit = fine_bit(cell);
    return (select(mask.x, mask.y, bit >= 32u) & (1u << (bit & 31u))) != 0u;
}

// The bit of the outermost sub-voxel of one of 16 columns towards a face, if the column is free in
// front of the voxel; 64 if there is none.
fn exposed_in_column(index: u32, face: u32, column: u32) -> u32 {
    let mask = vec2(masks[2u * index], masks[2u * index + 1u]);
    let axis = face >> 1u;
    let backward = (face & 1u) == 1u;
    var cell: vec3<u32>;
    cell[(axis + 1u) % 3u] = column % FINE;
    cell[(axis + 2u) % 3u] = column / FINE;
    let voxel = voxel_of_index(index);
    let at_border = voxel[axis] == select(volume.resolution - 1u, 0u, backward);
    if (!at_border) {
        var neighbor = voxel;
        neighbor[axis] = select(voxel[axis] + 1u, voxel[axis] - 1u, backward);
        let beyond = voxel_index(level_of_index(index), neighbor);
        cell[axis] = select(0u, FINE - 1u, backward);
        if (is_set(vec2(masks[2u * beyond], masks[2u * beyond + 1u]), cell)) {
            return 64u;
        }
    }
    for (var depth = 0u; depth < FINE; depth++) {
        cell[axis] = select(FINE - 1u - depth, depth, backward);
        if (is_set(mask, cell)) {
            return fine_bit(cell);
        }
    }
    return 64u;
}

// Whether the surface of a face of the voxel in which a ray ends is turned to the ray.
fn is_turned(hit: u32, direction: vec3<f32>, axis: u32) -> bool {
    let index = hit / 64u;
    let face = face_towards(axis, -direction[axis]);
    return face_key(index, face) != 0u && dot(direction, surface_normal(index, face)) < 0.0;
}

// Whether such a face shows at the sub-voxel in which the ray ends: that is the outermost towards
// the face. Without this rule the outside of a thin wall would be seen from within.
fn shows(hit: u32, direction: vec3<f32>, axis: u32) -> bool {
    if (!is_turned(hit, direction, axis)) {
        return false;
    }
    let cell = vec3(hit % FINE, (hit / FINE) % FINE, (hit / (FINE * FINE)) % FINE);
    let column = cell[(axis + 1u) % 3u] + FINE * cell[(axis + 2u) % 3u];
    return exposed_in_column(hit / 64u, face_towards(axis, -direction[axis]), column) == hit % 64u;
}

// A back that is met nearer than this, in voxels, may belong to the solid in which the ray began.
// Of a large solid only what is near its surface matters: receivers outside interpolate with it.
const NEAR: f32 = 4.0;

// Whether the last ray met the back of a surface with one side, which is black. Else, if no face
// shows, it ended in the edge between surfaces, which tells nothing.
fn meets_back(hit: u32, direction: vec3<f32>) -> bool {
    return !(is_turned(hit, direction, 0u) || is_turned(hit, direction, 1u)
        || is_turned(hit, direction, 2u));
}

// Whether the last ray, which met something of which no face shows, may have begun inside of it.
fn is_enclosed(is_back: bool) -> bool {
    return !is_back || travelled < NEAR;
}

// Whether the last ray ends at the front of any surface.
fn sees_front(hit: u32, direction: vec3<f32>) -> bool {
    return shows(hit, direction, 0u) || shows(hit, direction, 1u) || shows(hit, direction, 2u);
}

fn point_count(exposed: vec2<u32>) -> u32 {
    return countOneBits(exposed.x) + countOneBits(exposed.y);
}

fn cell_center(bit: u32) -> vec3<f32> {
    let cell = vec3(bit % FINE, (bit / FINE) % FINE, bit / (FINE * FINE));
    return (vec3<f32>(cell) + 0.5) / f32(FINE);
}

// The bit of the number-th exposed sub-voxel.
fn nth_bit(exposed: vec2<u32>, number: u32) -> u32 {
    let low = countOneBits(exposed.x);
    var word = select(exposed.x, exposed.y, number >= low);
    for (var i = select(number, number - low, number >= low); i > 0u; i--) {
        word &= word - 1u;
    }
    return countTrailingZeros(word) + select(0u, 32u, number >= low);
}

// The plane of a surface in its voxel.
struct SurfacePlane {
    // Mean of its points, from the voxel's corner.
    centroid: vec3<f32>,
    // How far in front of the points rays begin: outside of what the surface itself touches.
    guard: f32,
}

// Distance beyond what a surface touches at which its rays begin, in voxels.
const CLEARANCE: f32 = 0.00390625;

fn surface_plane(exposed: vec2<u32>, normal: vec3<f32>) -> SurfacePlane {
    let count = point_count(exposed);
    var centroid = vec3(0.0);
    var spread = 0.0;
    for (var i = 0u; i < count; i++) {
        centroid += cell_center(nth_bit(exposed, i));
    }
    centroid /= f32(max(count, 1u));
    for (var i = 0u; i < count; i++) {
        spread = max(spread, dot(normal, cell_center(nth_bit(exposed, i)) - centroid));
    }
    let reach = 0.5 / f32(FINE) * (abs(normal.x) + abs(normal.y) + abs(normal.z));
    return SurfacePlane(centroid, reach + min(spread, reach) + CLEARANCE);
}

// An exposed sub-voxel's centre, moved into the surface's plane; from the voxel's corner.
fn surface_point(exposed: vec2<u32>, plane: SurfacePlane, normal: vec3<f32>, number: u32)
    -> vec3<f32> {
    let center = cell_center(nth_bit(exposed, number));
    return center - normal * dot(normal, center - plane.centroid);
}

// A place is nearer than another if it is by more than this, in voxels squared: how floats are
// rounded then does not matter.
const NEARER: f32 = 1e-4;

// The point of a surface that is nearest to the middle of its voxel.
fn middle_point(exposed: vec2<u32>, plane: SurfacePlane, normal: vec3<f32>) -> vec3<f32> {
    var middle = vec3(0.5);
    var least = 3e38;
    for (var i = 0u; i < point_count(exposed); i++) {
        let point = surface_point(exposed, plane, normal, i);
        let way = point - 0.5;
        let flat = way - normal * dot(normal, way);
        if (dot(flat, flat) < least - NEARER) {
            middle = point;
            least = dot(flat, flat);
        }
    }
    return middle;
}

// Whether nothing is between two places, in voxels of a level.
fn is_clear(level: u32, start: vec3<f32>, end: vec3<f32>) -> bool {
    let way = end - start;
    let distance = length(way);
    return distance < 1e-4 || trace(level, start, way / distance, distance) == NOTHING;
}

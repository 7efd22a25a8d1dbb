// The surfaces in a voxel: which faces they stand for, and the points from which light is
// gathered, in `reference/surface.rs` step by step.

#define_import_path bevy_voxel_gi::surface

#import bevy_voxel_gi::faces::face_key
#import bevy_voxel_gi::volume::{FINE, face_towards}
#import bevy_voxel_gi::walk::{NOTHING, walk}

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

fn point_count(exposed: vec2<u32>) -> u32 {
    return countOneBits(exposed.x) + countOneBits(exposed.y);
}

fn cell_center(bit: u32) -> vec3<f32> {
    let cell = vec3(bit % FINE, (bit / FINE) % FINE, bit / (FINE * FINE));
    return (vec3<f32>(cell) + 0.5) / f32(FINE);
}

// Of some.
fn first_bit(exposed: vec2<u32>) -> u32 {
    return select(32u + firstTrailingBit(exposed.y), firstTrailingBit(exposed.x), exposed.x != 0u);
}

fn without_first(exposed: vec2<u32>) -> vec2<u32> {
    if (exposed.x != 0u) {
        return vec2(exposed.x & (exposed.x - 1u), exposed.y);
    }
    return vec2(0u, exposed.y & (exposed.y - 1u));
}

// The bit of the number-th exposed sub-voxel.
fn nth_bit(exposed: vec2<u32>, number: u32) -> u32 {
    var left = exposed;
    for (var i = 0u; i < number; i++) {
        left = without_first(left);
    }
    return first_bit(left);
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
    var centroid = vec3(0.0);
    for (var left = exposed; any(left != vec2(0u)); left = without_first(left)) {
        centroid += cell_center(first_bit(left));
    }
    centroid /= f32(max(point_count(exposed), 1u));
    var spread = 0.0;
    for (var left = exposed; any(left != vec2(0u)); left = without_first(left)) {
        spread = max(spread, dot(normal, cell_center(first_bit(left)) - centroid));
    }
    let reach = 0.5 / f32(FINE) * (abs(normal.x) + abs(normal.y) + abs(normal.z));
    return SurfacePlane(centroid, reach + min(spread, reach) + CLEARANCE);
}

// A place of a surface moved into its plane, from the voxel's corner.
fn in_plane(place: vec3<f32>, plane: SurfacePlane, normal: vec3<f32>) -> vec3<f32> {
    return place - normal * dot(normal, place - plane.centroid);
}

// The centre of the number-th exposed sub-voxel, in the surface's plane.
fn surface_point(exposed: vec2<u32>, plane: SurfacePlane, normal: vec3<f32>, number: u32)
    -> vec3<f32> {
    return in_plane(cell_center(nth_bit(exposed, number)), plane, normal);
}

// A place is nearer than another if it is by more than this, in voxels squared: how floats are
// rounded then does not matter.
const NEARER: f32 = 1e-4;

// The point of a surface that is nearest to the middle of its voxel.
fn middle_point(exposed: vec2<u32>, plane: SurfacePlane, normal: vec3<f32>) -> vec3<f32> {
    var middle = vec3(0.5);
    var least = 3e38;
    for (var left = exposed; any(left != vec2(0u)); left = without_first(left)) {
        let point = in_plane(cell_center(first_bit(left)), plane, normal);
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
    return distance < 1e-4
        || walk(level, start, way / distance, 0.0, distance).index == NOTHING;
}

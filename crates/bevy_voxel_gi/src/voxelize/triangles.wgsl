// Triangles of Bevy's meshes, in the cells of a level, and how they are written into voxels.

#define_import_path bevy_voxel_gi::triangles

#import bevy_voxel_gi::volume::{
    FACES, FINE, face_towards, fine_bit, level_corner, level_voxel_size, pack_key, volume,
    voxel_index,
}

// In step with `instances.rs`.
struct Instance {
    world_from_local: mat4x4<f32>,
    // In words of the vertex buffer.
    vertex_base: u32,
    vertex_stride: u32,
    position_offset: u32,
    joint_index_offset: u32,
    joint_weight_offset: u32,
    first_joint: u32,
    // In elements of the index buffer.
    index_base: u32,
    // Bytes of an index; 0: none.
    index_size: u32,
    triangle_count: u32,
    material: u32,
    flags: u32,
    // Share of its sub-voxels that are marked: below 1 where a mask cuts holes.
    coverage: f32,
    // In words of the morph targets, all vertices of a target one behind the other.
    morph_base: u32,
    vertex_count: u32,
    // In matrices, 16 in each.
    first_weights: u32,
    weight_count: u32,
}

const INSTANCE_SKINNED: u32 = 1u;
const INSTANCE_DOUBLE_SIDED: u32 = 2u;
// Its transform mirrors: triangles wind the other way.
const INSTANCE_MIRRORED: u32 = 4u;
// A strip: each corner but the first two makes a triangle with the two before.
const INSTANCE_STRIP: u32 = 8u;
const NO_INDICES: u32 = 0u;

// Up to 64 triangles for one workgroup.
struct Batch {
    instance: u32,
    first_triangle: u32,
    level: u32,
    pad: u32,
}

@group(0) @binding(1) var<storage, read_write> masks: array<atomic<u32>>;
@group(0) @binding(2) var<storage, read_write> faces: array<atomic<u32>>;
@group(1) @binding(0) var<storage, read> vertices: array<u32>;
@group(1) @binding(1) var<storage, read> indices: array<u32>;
@group(1) @binding(2) var<storage, read> instances: array<Instance>;
@group(1) @binding(3) var<storage, read> batches: array<Batch>;
// Of joints, and weights of morph targets.
@group(1) @binding(4) var<storage, read> joints: array<mat4x4<f32>>;
@group(1) @binding(5) var<storage, read> morph_targets: array<f32>;
// Words of a vertex in them.
const MORPH_WORDS: u32 = 12u;

// How far a triangle is moved against its normal, and by how much its bounds shrink, in voxels:
// what lies exactly between two layers of cells is thereby in the one behind it, and what ends there
// touches one of them, however it was rounded.
const SINK: f32 = 0.0009765625;

// A triangle in units of sub-voxels from the corner of its level.
struct Triangle {
    a: vec3<f32>,
    b: vec3<f32>,
    c: vec3<f32>,
    // Unit length; zero: not to be drawn.
    normal: vec3<f32>,
}

// Components in the order of projection along an axis: the two in the plane, then depth.
fn turned(v: vec3<f32>, axis: u32) -> vec3<f32> {
    return vec3(v[(axis + 1u) % 3u], v[(axis + 2u) % 3u], v[axis]);
}

fn turned_back(v: vec3<u32>, axis: u32) -> vec3<u32> {
    var result: vec3<u32>;
    result[(axis + 1u) % 3u] = v.x;
    result[(axis + 2u) % 3u] = v.y;
    result[axis] = v.z;
    return result;
}

// The axis along which a triangle's projection is the largest.
fn main_axis(normal: vec3<f32>) -> u32 {
    let n = abs(normal);
    return select(select(2u, 1u, n.y >= n.z), 0u, n.x >= n.y && n.x >= n.z);
}

fn vertex_of(instance: Instance, corner: u32) -> u32 {
    if (instance.index_size == NO_INDICES) {
        return corner;
    }
    let element = instance.index_base + corner;
    if (instance.index_size == 4u) {
        return indices[element];
    }
    return (indices[element >> 1u] >> ((element & 1u) * 16u)) & 0xffffu;
}

fn read_vec3(at: u32) -> vec3<f32> {
    return bitcast<vec3<f32>>(vec3(vertices[at], vertices[at + 1u], vertices[at + 2u]));
}

// How far morph targets move a vertex.
fn morph(instance: Instance, vertex: u32) -> vec3<f32> {
    var sum = vec3(0.0);
    for (var i = 0u; i < instance.weight_count; i++) {
        let weights = joints[instance.first_weights + i / 16u];
        let weight = weights[(i / 4u) % 4u][i % 4u];
        if (weight != 0.0) {
            let at = instance.morph_base
                + MORPH_WORDS * (i * instance.vertex_count + vertex);
            sum += weight
                * vec3(morph_targets[at], morph_targets[at + 1u], morph_targets[at + 2u]);
        }
    }
    return sum;
}

fn skin(instance: Instance, at: u32) -> mat4x4<f32> {
    let j = at + instance.joint_index_offset;
    let w = at + instance.joint_weight_offset;
    let joint = vec4(vertices[j] & 0xffffu, vertices[j] >> 16u, vertices[j + 1u] & 0xffffu,
        vertices[j + 1u] >> 16u) + instance.first_joint;
    return bitcast<f32>(vertices[w]) * joints[joint.x]
        + bitcast<f32>(vertices[w + 1u]) * joints[joint.y]
        + bitcast<f32>(vertices[w + 2u]) * joints[joint.z]
        + bitcast<f32>(vertices[w + 3u]) * joints[joint.w];
}

fn world_position(instance: Instance, corner: u32) -> vec3<f32> {
    let vertex = vertex_of(instance, corner);
    let at = instance.vertex_base + vertex * instance.vertex_stride;
    let position = vec4(read_vec3(at + instance.position_offset) + morph(instance, vertex), 1.0);
    if ((instance.flags & INSTANCE_SKINNED) != 0u) {
        return (skin(instance, at) * position).xyz;
    }
    return (instance.world_from_local * position).xyz;
}

// The triangle of a batch; its normal is zero if there is none, if it has no area, or if it is
// not finite.
fn load_triangle(batch: Batch, instance: Instance, number: u32) -> Triangle {
    var triangle: Triangle;
    let id = batch.first_triangle + number;
    if (id >= instance.triangle_count) {
        return triangle;
    }
    let corner = level_corner(batch.level);
    let cells_per_metre = f32(FINE) / level_voxel_size(batch.level);
    var corners = 3u * id + vec3(0u, 1u, 2u);
    if ((instance.flags & INSTANCE_STRIP) != 0u) {
        let odd = id & 1u;
        corners = id + vec3(0u, 1u + odd, 2u - odd);
    }
    triangle.a = (world_position(instance, corners.x) - corner) * cells_per_metre;
    triangle.b = (world_position(instance, corners.y) - corner) * cells_per_metre;
    triangle.c = (world_position(instance, corners.z) - corner) * cells_per_metre;
    let normal = cross(triangle.b - triangle.a, triangle.c - triangle.a);
    let length_squared = dot(normal, normal);
    // False for NaN too.
    if (length_squared > 0.0 && length_squared < 1e36) {
        triangle.normal = normal * inverseSqrt(length_squared);
        if ((instance.flags & INSTANCE_MIRRORED) != 0u) {
            triangle.normal = -triangle.normal;
        }
        let sunk = SINK * f32(FINE) * triangle.normal;
        triangle.a -= sunk;
        triangle.b -= sunk;
        triangle.c -= sunk;
    }
    return triangle;
}

// Those of the sub-voxels in which a mask leaves something: as many as coverage says, spread evenly
// over the surface (the R2 sequence as a threshold; M. Roberts, "The Unreasonable Effectiveness of
// Quasirandom Sequences", 2018), and the same wherever the volume is.
fn covered(batch: Batch, instance: Instance, voxel: vec3<u32>, touched: vec2<u32>,
    normal: vec3<f32>) -> vec2<u32> {
    let cells_per_metre = f32(FINE) / level_voxel_size(batch.level);
    let corner = vec3<i32>(round(level_corner(batch.level) * cells_per_metre));
    let axis = main_axis(normal);
    var mask = vec2(0u);
    for (var bit = 0u; bit < 64u; bit++) {
        if ((touched[bit >> 5u] & (1u << (bit & 31u))) == 0u) {
            continue;
        }
        let fine = vec3(bit % FINE, (bit / FINE) % FINE, bit / (FINE * FINE));
        let cell = corner + vec3<i32>(FINE * voxel + fine);
        // 0.7548777 and 0.5698403 of 2^32; overflow is the fraction.
        let u = bitcast<u32>(cell[(axis + 1u) % 3u]) * 3242174889u;
        let v = bitcast<u32>(cell[(axis + 2u) % 3u]) * 2447445414u;
        if (f32((u + v) >> 8u) / 16777216.0 < instance.coverage) {
            mask[bit >> 5u] |= 1u << (bit & 31u);
        }
    }
    return mask;
}

// Marks sub-voxels of a voxel and offers the surface to the faces that it faces.
fn mark(batch: Batch, instance: Instance, voxel: vec3<u32>, touched: vec2<u32>,
    normal: vec3<f32>) {
    let index = voxel_index(batch.level, voxel);
    var mask = touched;
    if (instance.coverage < 1.0) {
        mask = covered(batch, instance, voxel, touched, normal);
        if (all(mask == vec2(0u))) {
            return;
        }
    }
    if (mask.x != 0u) {
        atomicOr(&masks[2u * index], mask.x);
    }
    if (mask.y != 0u) {
        atomicOr(&masks[2u * index + 1u], mask.y);
    }
#ifndef OCCLUSION_ONLY
    let share = f32(countOneBits(mask.x) + countOneBits(mask.y));
    offer(instance, index, normal, share);
    if ((instance.flags & INSTANCE_DOUBLE_SIDED) != 0u) {
        offer(instance, index, -normal, share);
    }
#endif
}

// Surfaces that a face sees at a smaller cosine than this are not its own.
const LEAST_FACING: f32 = 0.125;
// Sub-voxels times the squared cosine, by this, is a key's weight.
const WEIGHT_SCALE: f32 = 8.0;

fn offer(instance: Instance, index: u32, normal: vec3<f32>, sub_voxels: f32) {
    for (var axis = 0u; axis < 3u; axis++) {
        let facing = normal[axis];
        if (abs(facing) > LEAST_FACING) {
            let weight = ceil(sub_voxels * facing * facing * WEIGHT_SCALE);
            let key = pack_key(weight, normal, instance.material);
            atomicMax(&faces[FACES * index + face_towards(axis, facing)], key);
        }
    }
}

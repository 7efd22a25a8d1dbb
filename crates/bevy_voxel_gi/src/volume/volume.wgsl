// The voxels as every pass sees them: where they are in the world and what is stored of each.

#define_import_path bevy_voxel_gi::volume

// In step with `gpu.rs`.
// A cube of voxels: a volume, or a cascade of one.
struct Level {
    // The corner with the smallest coordinates in the world.
    corner: vec3<f32>,
    // Edge of a voxel in metres.
    voxel_size: f32,
    // Radiance from outside, scaled by `storage_scale`.
    sky_zenith: vec3<f32>,
    // Factor of the light that reaches the image.
    intensity: f32,
    sky_horizon: vec3<f32>,
    sky_ground: vec3<f32>,
}

// In step with `gpu.rs`.
struct Volume {
    // The smallest voxels first.
    levels: array<Level, 8>,
    // Edges of the box around all levels in metres.
    extent: vec3<f32>,
    // Voxels along an edge of a level.
    resolution: u32,
    // Middle of that box in the world.
    center: vec3<f32>,
    level_count: u32,
    light_count: u32,
    // Factor of all stored light, so that 16-bit floats hold it.
    storage_scale: f32,
    // Exposure at which unexposed emission is meant.
    exposure: f32,
    rays: u32,
    shadow_samples: u32,
    // Obstacles further away than this are not seen, in metres.
    max_distance: f32,
    // Which voxels are renewed now: those whose slice is `phase` modulo `interval`.
    phase: u32,
    interval: u32,
    flags: u32,
    // Counts the rounds, in each of which every voxel is renewed once.
    round: u32,
    points_per_triangle: u32,
    air_interval: u32,
    // Share of this round in the mean that pixels read.
    blend: f32,
}

@group(0) @binding(0) var<uniform> volume: Volume;

// Reflected light of the frame before is reflected again.
const FLAG_FEEDBACK: u32 = 1u;
// The receiver divides by the weight in alpha.
const FLAG_WEIGHTED: u32 = 2u;
// Something in the scene has changed lately.
const FLAG_CHANGING: u32 = 4u;

// Faces of a voxel: +X, -X, +Y, -Y, +Z, -Z.
const FACES: u32 = 6u;
// Sub-voxels along a voxel's edge.
const FINE: u32 = 4u;

// Of a level.
fn voxel_count() -> u32 {
    return volume.resolution * volume.resolution * volume.resolution;
}

// Edge of a voxel of a level in metres.
fn level_voxel_size(level: u32) -> f32 {
    return volume.levels[level].voxel_size;
}

// The corner of a level with the smallest coordinates.
fn level_corner(level: u32) -> vec3<f32> {
    return volume.levels[level].corner;
}

// Index of a voxel over all levels; x runs fastest.
fn voxel_index(level: u32, voxel: vec3<u32>) -> u32 {
    let r = volume.resolution;
    return level * voxel_count() + voxel.x + r * (voxel.y + r * voxel.z);
}

fn level_of_index(index: u32) -> u32 {
    return index / voxel_count();
}

fn voxel_of_index(index: u32) -> vec3<u32> {
    let r = volume.resolution;
    let local = index % voxel_count();
    return vec3(local % r, (local / r) % r, local / (r * r));
}

// Whether a voxel is renewed now.
fn is_due(index: u32) -> bool {
    return voxel_of_index(index).z % volume.interval == volume.phase;
}

fn face_normal(face: u32) -> vec3<f32> {
    var normal = vec3(0.0);
    normal[face >> 1u] = select(1.0, -1.0, (face & 1u) == 1u);
    return normal;
}

// The face on this side of an axis.
fn face_towards(axis: u32, component: f32) -> u32 {
    return 2u * axis + select(0u, 1u, component < 0.0);
}

// Bit of a sub-voxel in the 64 of its voxel: x + 4 (y + 4 z).
fn fine_bit(cell: vec3<u32>) -> u32 {
    return cell.x + FINE * (cell.y + FINE * cell.z);
}

// Octahedral encoding of a unit vector in 6 + 6 bits.
fn pack_normal(n: vec3<f32>) -> u32 {
    let p = n.xy / (abs(n.x) + abs(n.y) + abs(n.z));
    let folded = (1.0 - abs(p.yx)) * select(vec2(-1.0), vec2(1.0), p >= vec2(0.0));
    let q = select(p, folded, n.z < 0.0);
    // 62 steps, so that zero is one of them and axes are exact.
    let u = vec2<u32>(clamp(round(q * 31.0 + 31.0), vec2(0.0), vec2(62.0)));
    return u.x | (u.y << 6u);
}

fn unpack_normal(bits: u32) -> vec3<f32> {
    let q = vec2(f32(bits & 63u), f32((bits >> 6u) & 63u)) / 31.0 - 1.0;
    var n = vec3(q, 1.0 - abs(q.x) - abs(q.y));
    let fold = max(-n.z, 0.0);
    n.x += select(fold, -fold, n.x >= 0.0);
    n.y += select(fold, -fold, n.y >= 0.0);
    return normalize(n);
}

// The surface that represents a face of a voxel: weight, normal and material in one word, so that
// the maximum of words is the surface with the greatest weight, whatever the order.
fn pack_key(weight: f32, normal: vec3<f32>, material: u32) -> u32 {
    let w = u32(clamp(weight, 1.0, 255.0));
    return (w << 24u) | (pack_normal(normal) << 12u) | min(material, 4095u);
}

fn key_normal(key: u32) -> vec3<f32> {
    return unpack_normal((key >> 12u) & 4095u);
}

fn key_material(key: u32) -> u32 {
    return key & 4095u;
}

// The sky around a level, seen in a direction.
fn sky_radiance(level: u32, direction: vec3<f32>) -> vec3<f32> {
    let up = clamp(direction.y, -1.0, 1.0);
    let zenith = volume.levels[level].sky_zenith;
    let other = select(volume.levels[level].sky_ground, zenith, up > 0.0);
    return mix(volume.levels[level].sky_horizon, other, abs(up));
}

// Directions of rays, and what makes them differ from voxel to voxel.

#define_import_path bevy_voxel_gi::rays

const PI: f32 = 3.14159265358979;
// 2 pi (1 - 1 / golden ratio): each ray turns by this against the one before.
const GOLDEN_ANGLE: f32 = 2.3999632;

// A well-mixed number from 0 to below 1 (M. Jarzynski and M. Olano, "Hash Functions for GPU
// Rendering", 2020: pcg).
fn hash_unit(value: u32) -> f32 {
    let state = value * 747796405u + 2891336453u;
    let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return f32(((word >> 22u) ^ word) >> 8u) / 16777216.0;
}

// Ray `i` of `count` about a normal, as many per solid angle as the cosine says: the mean of what
// they bring, times pi, is the irradiance. `turn`, 0 to 1, turns them all about the normal.
fn cosine_ray(i: u32, count: u32, turn: f32, normal: vec3<f32>) -> vec3<f32> {
    let squared = (f32(i) + 0.5) / f32(count);
    let angle = f32(i) * GOLDEN_ANGLE + turn * 2.0 * PI;
    // T. Duff et al., "Building an Orthonormal Basis, Revisited", 2017.
    let sign = select(1.0, -1.0, normal.z < 0.0);
    let a = -1.0 / (sign + normal.z);
    let b = normal.x * normal.y * a;
    let tangent = vec3(1.0 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x);
    let bitangent = vec3(b, sign + normal.y * normal.y * a, -normal.y);
    let r = sqrt(squared);
    return tangent * (r * cos(angle)) + bitangent * (r * sin(angle))
        + normal * sqrt(max(1.0 - squared, 0.0));
}

// Ray `i` of `count` in all directions alike: the sum of what they bring times the cosine, times
// 4 pi / count, is the irradiance.
fn sphere_ray(i: u32, count: u32, turn: f32) -> vec3<f32> {
    let z = 1.0 - 2.0 * (f32(i) + 0.5) / f32(count);
    let angle = f32(i) * GOLDEN_ANGLE + turn * 2.0 * PI;
    let r = sqrt(max(1.0 - z * z, 0.0));
    return vec3(r * cos(angle), r * sin(angle), z);
}

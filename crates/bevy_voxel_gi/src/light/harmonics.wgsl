// Spherical harmonics of second order: four coefficients (thesis section 6.5.4).
//
// The basis: Y0 = 1 / (2 sqrt(pi)), and sqrt(3 / (4 pi)) times y, z and x, in this order and without
// signs.

#define_import_path bevy_voxel_gi::harmonics

const Y0: f32 = 0.2820948;
const Y1: f32 = 0.4886025;

// The four functions in a direction.
fn basis(direction: vec3<f32>) -> vec4<f32> {
    return vec4(Y0, Y1 * direction.yzx);
}

// The clamped cosine about a unit normal, with a flux of 1 (thesis Eq. 6.5, as corrected, over pi).
fn cosine_lobe(normal: vec3<f32>) -> vec4<f32> {
    return vec4(0.2820948, 0.3257350 * normal.yzx);
}

// The integral over all directions.
fn flux(coefficients: vec4<f32>) -> f32 {
    return 3.5449077 * coefficients.x;
}

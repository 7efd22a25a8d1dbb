//! Second-order spherical harmonics: 4 coefficients (thesis 6.5.4).
//!
//! The basis, here and in the shaders, is Y0 = 1 / (2 sqrt(pi)), and sqrt(3 / (4 pi)) times y, z and x,
//! in this order and without signs.

use glam::{Vec3, Vec4};
use std::f32::consts::PI;

/// The constant basis function, 1 / (2 sqrt(pi)).
pub const Y0: f32 = 0.282_094_8;
/// Factor of the linear basis functions, sqrt(3 / (4 pi)).
pub const Y1: f32 = 0.488_602_5;

/// Returns the four basis functions in a direction.
pub fn basis(direction: Vec3) -> Vec4 {
    Vec4::new(Y0, Y1 * direction.y, Y1 * direction.z, Y1 * direction.x)
}

/// Returns the clamped cosine about a unit normal (thesis Eq. 6.5, as corrected); its flux is pi.
pub fn cosine_lobe(normal: Vec3) -> Vec4 {
    let (a, b) = (0.5 * PI.sqrt(), (PI / 3.0).sqrt());
    Vec4::new(a, b * normal.y, b * normal.z, b * normal.x)
}

/// Returns the integral over all directions.
pub fn flux(coefficients: Vec4) -> f32 {
    2.0 * PI.sqrt() * coefficients.x
}

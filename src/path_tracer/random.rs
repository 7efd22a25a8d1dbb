//! Numbers that look random.

use std::f32::consts::TAU;

use bevy::math::{Vec2, Vec3};

/// Numbers that look random: the same for the same path of the same pixel (PCG).
pub(super) struct Random(u32);

impl Random {
    pub(super) fn new(pixel: u32, sample: u32, seed: u32) -> Self {
        let mut state = Self(seed);
        for part in [pixel, sample] {
            state.0 = state.bits() ^ part;
        }
        state.bits();
        state
    }

    pub(super) fn bits(&mut self) -> u32 {
        self.0 = self.0.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        let word = ((self.0 >> ((self.0 >> 28) + 4)) ^ self.0).wrapping_mul(277_803_737);
        (word >> 22) ^ word
    }

    /// From 0 to below 1.
    pub(super) fn unit(&mut self) -> f32 {
        unit(self.bits())
    }

    /// A point of the unit square.
    pub(super) fn point(&mut self) -> Vec2 {
        Vec2::new(self.unit(), self.unit())
    }
}

/// Points of the unit square that the samples of a pixel or receiver spread over evenly (the R2 sequence).
pub(super) struct Spread([u32; 2]);

impl Spread {
    pub(super) fn new(index: u32, seed: u32) -> Self {
        let mut start = Random::new(index, u32::MAX, seed);
        Self([start.bits(), start.bits()])
    }

    pub(super) fn point(&self, sample: u32) -> Vec2 {
        let [a, b] = [3_242_174_889_u32, 2_447_445_414].map(|step| step.wrapping_mul(sample));
        Vec2::new(
            unit(a.wrapping_add(self.0[0])),
            unit(b.wrapping_add(self.0[1])),
        )
    }
}

fn unit(bits: u32) -> f32 {
    (bits >> 8) as f32 / (1 << 24) as f32
}

/// A direction around a normal, as likely as its cosine is large, from a point of the unit square.
pub(super) fn cosine_direction(normal: Vec3, at: Vec2) -> Vec3 {
    let (sin, cos) = (TAU * at.x).sin_cos();
    let radius = at.y.sqrt();
    let (tangent, bitangent) = normal.any_orthonormal_pair();
    radius * (cos * tangent + sin * bitangent) + (1.0 - at.y).max(0.0).sqrt() * normal
}

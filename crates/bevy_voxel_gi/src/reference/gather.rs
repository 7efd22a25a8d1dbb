//! Gathers the light that arrives at a surface or in the centre of a voxel, by ray tracing.

use super::{grid::FACES, surface::Surface, trace::RaySample};
use glam::{Vec3, Vec4};
use rays::{cosine_ray, hash_unit, sphere_ray};

/// Number of ray sets, one of which is traced per frame in rotation: together they form one dense set.
pub const RAY_SETS: u32 = 8;

/// Number of points of a surface at which rays start in a frame.
pub const FRAME_POINTS: u32 = 4;

/// Stride from point to point, so that neighbouring points are not in the same frame; coprime to 16.
pub const POINT_STEP: u32 = 5;

/// Weight of a surface, relative to 1, that is inside geometry: in a solid, or close behind a single-sided
/// surface. Its light is too dark, and must not show in pixels just outside of the solid.
pub const INSIDE_WEIGHT: f32 = 1.0 / 256.0;

/// Weight of an empty voxel in the same case, relative to other empty voxels.
pub const EMPTY_INSIDE_WEIGHT: f32 = 1.0 / 4.0;

fn rotation(voxel: usize, salt: u32, frame: u32) -> f32 {
    let series = (frame / RAY_SETS).wrapping_mul(0x9e37_79b9);
    hash_unit(
        (voxel as u32)
            .wrapping_mul(64)
            .wrapping_add(salt)
            .wrapping_add(series),
    )
}

/// The result of several rays.
#[derive(Clone, Copy, Default)]
struct Gathered {
    /// Radiance times weight, and weight, of the valid samples.
    light: Vec4,
    rays: f32,
    /// Number of rays that end at a back or in a wall.
    enclosed: f32,
    /// Number of these that may start inside geometry.
    inside_geometry: f32,
}

impl Gathered {
    fn add(&mut self, sample: RaySample<Vec3>, weight: f32) {
        self.rays += 1.0;
        self.enclosed += f32::from(u8::from(sample.is_enclosed()));
        self.inside_geometry += f32::from(u8::from(sample.is_inside_geometry()));
        match sample {
            RaySample::Light(radiance) => self.light += radiance.extend(1.0) * weight,
            RaySample::BackFace(_) => self.light.w += weight,
            RaySample::Invalid => {}
        }
    }

    /// Whether more than a quarter of the rays are enclosed, and an eighth may start inside geometry. Not all of them
    /// need be, as solids may overlap: in one, the fronts of others are visible.
    fn is_inside_geometry(&self) -> bool {
        4.0 * self.enclosed > self.rays && 8.0 * self.inside_geometry >= self.rays
    }
}

/// Mean radiance of rays about a surface's normal, distributed in proportion to the cosine, times a
/// weight; and that weight.
///
/// `arriving` returns the radiance along a ray from an origin in grid coordinates. The weight is the
/// fraction of valid samples; if all points are inside geometry it is [`INSIDE_WEIGHT`], else only the points
/// outside are used. `rays` is a multiple of [`FRAME_POINTS`].
pub fn hemisphere(
    surface: &Surface,
    rays: u32,
    frame: u32,
    arriving: impl Fn(Vec3, Vec3) -> RaySample<Vec3>,
) -> Vec4 {
    let rotation = rotation(surface.voxel, u32::from(surface.faces), frame);
    let (mut outside, mut inside) = (Vec4::ZERO, Vec4::ZERO);
    for k in 0..FRAME_POINTS {
        let step = frame.wrapping_mul(FRAME_POINTS).wrapping_add(k);
        let number = step.wrapping_mul(POINT_STEP) as usize;
        let origin = surface.origin(surface.one_side[number % surface.one_side.len()]);
        let mut found = Gathered::default();
        for i in (k..rays).step_by(FRAME_POINTS as usize) {
            let index = i * RAY_SETS + frame % RAY_SETS;
            let direction = cosine_ray(index, rays * RAY_SETS, rotation, surface.normal);
            found.add(arriving(origin, direction), 1.0);
        }
        if found.is_inside_geometry() {
            inside += found.light;
        } else {
            outside += found.light;
        }
    }
    if outside.w > 0.0 {
        outside / rays as f32
    } else {
        inside / inside.w.max(1.0) * INSIDE_WEIGHT
    }
}

/// Mean radiance in the centre of an empty voxel, for its six faces, of the same rays in each frame. All weights are
/// `weight`, times [`EMPTY_INSIDE_WEIGHT`] inside geometry. `seed` is that of [`VolumeGrid::seed_in_world`](super::grid::VolumeGrid::seed_in_world).
pub fn sphere(
    seed: u32,
    center: Vec3,
    rays: u32,
    weight: f32,
    arriving: impl Fn(Vec3, Vec3) -> RaySample<Vec3>,
) -> [Vec4; 6] {
    let rotation = hash_unit(seed);
    let mut found = [Gathered::default(); 6];
    for i in 0..rays {
        let direction = sphere_ray(i, rays, rotation);
        let sample = arriving(center, direction);
        for (found, face) in found.iter_mut().zip(FACES) {
            // Weighted by the cosine, so that a uniform field stays uniform however few rays there are.
            found.add(sample, direction.dot(face).max(0.0));
        }
    }
    found.map(|found| {
        let factor = if found.is_inside_geometry() {
            EMPTY_INSIDE_WEIGHT
        } else {
            1.0
        };
        found.light / found.light.w.max(1e-6) * (weight * factor)
    })
}

/// Ray directions, and the hash that rotates them differently in each voxel.
pub mod rays {
    use glam::Vec3;
    use std::f32::consts::TAU;

    /// 2 pi (1 - 1 / golden ratio): the rotation from each ray to the next.
    pub const GOLDEN_ANGLE: f32 = 2.399_963_2;

    /// Returns a pseudo-random integer (M. Jarzynski and M. Olano, *Hash Functions for GPU Rendering*, 2020:
    /// pcg).
    pub fn hash(value: u32) -> u32 {
        let state = value.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
        (word >> 22) ^ word
    }

    /// Returns [`hash`] as a number from 0 to below 1.
    pub fn hash_unit(value: u32) -> f32 {
        (hash(value) >> 8) as f32 / (1 << 24) as f32
    }

    /// Returns two unit vectors that form an orthonormal basis with a unit vector
    /// (T. Duff et al., *Building an Orthonormal Basis, Revisited*, 2017).
    pub fn tangents(n: Vec3) -> (Vec3, Vec3) {
        let sign = if n.z < 0.0 { -1.0 } else { 1.0 };
        let a = -1.0 / (sign + n.z);
        let b = n.x * n.y * a;
        (
            Vec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x),
            Vec3::new(b, sign + n.y * n.y * a, -n.y),
        )
    }

    /// Returns ray `i` of `count` about a normal, with a density in proportion to the cosine: the mean of the
    /// rays' radiance, times pi, is the irradiance.
    ///
    /// `rotation`, 0 to 1, rotates all of them about the normal.
    pub fn cosine_ray(i: u32, count: u32, rotation: f32, normal: Vec3) -> Vec3 {
        let squared = (i as f32 + 0.5) / count as f32;
        let angle = i as f32 * GOLDEN_ANGLE + rotation * TAU;
        let (t, b) = tangents(normal);
        let r = squared.sqrt();
        t * (r * angle.cos()) + b * (r * angle.sin()) + normal * (1.0 - squared).max(0.0).sqrt()
    }

    /// Returns ray `i` of `count`, distributed uniformly over the sphere.
    ///
    /// `rotation`, 0 to 1, rotates all of them about z.
    pub fn sphere_ray(i: u32, count: u32, rotation: f32) -> Vec3 {
        let z = 1.0 - 2.0 * (i as f32 + 0.5) / count as f32;
        let angle = i as f32 * GOLDEN_ANGLE + rotation * TAU;
        let r = (1.0 - z * z).max(0.0).sqrt();
        Vec3::new(r * angle.cos(), r * angle.sin(), z)
    }
}

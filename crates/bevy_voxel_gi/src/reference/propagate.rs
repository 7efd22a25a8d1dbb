//! Light propagation from voxel to voxel (thesis 6.6.2), such that the energy never grows.
//!
//! Each empty voxel stores the intensity of the light that has just arrived in it, as spherical
//! harmonics of the second order: four coefficients (thesis 6.5.4). The basis, here and in the shaders, is
//! Y0 = 1 / (2 sqrt(pi)), and sqrt(3 / (4 pi)) times y, z and x, in this order and without signs.
//!
//! In each step all of it leaves through the six faces, in proportion to the intensity towards
//! the five other faces of the neighbour behind each (A. Kaplanyan and C. Dachsbacher, *Cascaded Light
//! Propagation Volumes*, 2010):
//!
//! ```text
//! f = max(I(w), 0) W                        w towards the centre of a face, W its solid angle
//! f' = f Phi / sum f                        over all 30, per channel; Phi is the flux of I
//! ```
//!
//! As much arrives as has left: no hand-set factor is needed. An empty neighbour receives each part as
//! light in its direction of travel, not as a cosine lobe towards that face, which would scatter it at
//! every step. Light that reaches an occupied voxel is irradiance there, and is reflected with the albedo
//! of its face as a cosine lobe about its normal; light that reaches the border is lost.

use super::{
    each,
    grid::{FACE_STEPS, FACES},
    irradiance_field::IrradianceField,
    packed_surface::packed_normal,
    ray_tracing::{RayTracing, face_materials},
    voxels::{Material, Voxels},
};
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

/// Solid angle of the far face of the neighbouring voxel, from the centre of a voxel.
pub const FRONT_ANGLE: f32 = 0.400_669_7;

/// Solid angle of each of its four side faces; with the far one they sum to 2 pi / 3.
pub const SIDE_ANGLE: f32 = 0.423_431_36;

/// Fraction of the flux that is kept in a step, so that rounding never adds to it.
pub const KEPT: f32 = 1.0 - 1.0 / (1 << 19) as f32;

/// Settings of the propagation solver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PropagationSettings {
    /// Number of steps; light travels one voxel per step.
    pub steps: u32,
    /// Weight of an empty voxel where receivers interpolate; surfaces have 1.
    pub empty_weight: f32,
}

impl Default for PropagationSettings {
    fn default() -> Self {
        Self {
            steps: 128,
            empty_weight: 1.0 / 64.0,
        }
    }
}

/// Spherical harmonics of each colour channel.
pub type Intensity = [Vec4; 3];

/// The propagation solver and its state.
pub struct Propagation<'a> {
    voxels: &'a Voxels,
    /// Per voxel: the material of each face.
    materials: Vec<[Material; 6]>,
    settings: PropagationSettings,
    /// Per voxel: intensity of the light that has just arrived, in lux times the area of a voxel's face.
    pub intensity: Vec<Intensity>,
    /// Per voxel and face: irradiance that has arrived through it so far, in lux.
    pub arrived: Vec<[Vec3; 6]>,
}

impl<'a> Propagation<'a> {
    /// Creates the state with the radiance of the surfaces of `ray_tracing` and with a sky.
    pub fn new(
        ray_tracing: &RayTracing<'a>,
        voxels: &'a Voxels,
        materials: &[Material],
        sky: Vec3,
        settings: PropagationSettings,
    ) -> Self {
        let grid = voxels.grid;
        let arrived = vec![[Vec3::ZERO; 6]; grid.len()];
        let mut all = Self {
            voxels,
            materials: face_materials(voxels, materials),
            settings,
            intensity: vec![[Vec4::ZERO; 3]; grid.len()],
            arrived,
        };
        for voxel in 0..grid.len() {
            for (face, direction) in FACES.into_iter().enumerate() {
                if let Some(neighbor) = all.empty_neighbor(voxel, face) {
                    let packed = voxels.packed_surfaces[voxel][face];
                    if voxels.masks[voxel] != 0 && packed != 0 {
                        let normal = packed_normal(packed);
                        let flux = ray_tracing.radiance[voxel][face] * PI * normal.dot(direction);
                        add(&mut all.intensity[neighbor], flux, normal);
                    }
                } else if all.is_empty(voxel) && all.neighbor(voxel, face).is_none() {
                    all.arrived[voxel][face] += sky * PI;
                    add(&mut all.intensity[voxel], sky * PI, -direction);
                }
            }
        }
        all
    }

    fn is_empty(&self, voxel: usize) -> bool {
        self.voxels.masks[voxel] == 0
    }

    fn neighbor(&self, voxel: usize, face: usize) -> Option<usize> {
        let grid = self.voxels.grid;
        grid.index(grid.voxel(voxel) + FACE_STEPS[face])
    }

    fn empty_neighbor(&self, voxel: usize, face: usize) -> Option<usize> {
        self.neighbor(voxel, face).filter(|v| self.is_empty(*v))
    }

    /// Returns the flux that is travelling, per channel, in lux times the area of a voxel's face.
    pub fn total_flux(&self) -> glam::DVec3 {
        self.intensity
            .iter()
            .map(|i| glam::DVec3::from_array(i.map(|c| f64::from(flux(c)))))
            .sum()
    }

    /// Computes one step.
    pub fn step(&mut self) {
        let leaving: Vec<Option<Leaving>> = each(self.intensity.len(), |voxel| {
            Leaving::new(&self.intensity[voxel])
        });
        let new = each(self.intensity.len(), |voxel| self.arrive(voxel, &leaving));
        for (voxel, (intensity, arrived)) in new.into_iter().enumerate() {
            self.intensity[voxel] = intensity;
            for (sum, new) in self.arrived[voxel].iter_mut().zip(arrived) {
                *sum += new;
            }
        }
    }

    fn arrive(&self, voxel: usize, leaving: &[Option<Leaving>]) -> (Intensity, [Vec3; 6]) {
        let mut intensity = [Vec4::ZERO; 3];
        let mut arrived = [Vec3::ZERO; 6];
        let is_free = self.is_empty(voxel);
        for (face, arrived) in arrived.iter_mut().enumerate() {
            let Some(neighbor) = self.neighbor(voxel, face) else {
                continue;
            };
            // From a neighbour, in the opposite direction.
            if let Some(from) = &leaving[neighbor] {
                let parts = from.parts[face ^ 1];
                *arrived = parts.iter().sum();
                if is_free {
                    for (side, part) in parts.into_iter().enumerate() {
                        let direction = basis(travel(face ^ 1, side).0);
                        for (channel, flux) in intensity.iter_mut().zip(part.to_array()) {
                            *channel += direction * flux;
                        }
                    }
                }
            }
            // Reflected by a surface.
            if is_free
                && !self.is_empty(neighbor)
                && let Some(own) = &leaving[voxel]
            {
                let (albedo, normal) = self.reflection(neighbor, face ^ 1);
                let part: Vec3 = own.parts[face].iter().sum();
                add(&mut intensity, part * albedo, normal);
            }
        }
        (intensity, arrived)
    }

    /// Albedo and normal of a voxel's face; if the face has no surface, the mean albedo of those that have
    /// one, and the face's own normal.
    fn reflection(&self, voxel: usize, face: usize) -> (Vec3, Vec3) {
        let packed_surfaces = self.voxels.packed_surfaces[voxel];
        let albedo = |face: usize| self.materials[voxel][face].albedo;
        if packed_surfaces[face] != 0 {
            return (albedo(face), packed_normal(packed_surfaces[face]));
        }
        let all = (0..6).filter(|face| packed_surfaces[*face] != 0);
        let count = all.clone().count().max(1) as f32;
        (all.map(albedo).sum::<Vec3>() / count, FACES[face])
    }

    /// Returns the field that receivers sample: irradiance, in lux.
    pub fn field(&self) -> IrradianceField {
        let texels = (0..self.arrived.len()).map(|voxel| {
            [0, 1, 2, 3, 4, 5].map(|face| {
                let weight = if self.is_empty(voxel) {
                    self.settings.empty_weight
                } else if self.voxels.packed_surfaces[voxel][face] != 0
                    && self.empty_neighbor(voxel, face).is_some()
                {
                    1.0
                } else {
                    0.0
                };
                (self.arrived[voxel][face] * weight).extend(weight)
            })
        });
        IrradianceField {
            grid: self.voxels.grid,
            texels: texels.collect(),
        }
    }

    /// Computes all steps of the settings.
    pub fn run(&mut self) {
        for _ in 0..self.settings.steps {
            self.step();
        }
    }
}

/// Direction from the centre of a voxel to a face of the neighbour behind `face`, and its solid angle.
fn travel(face: usize, side: usize) -> (Vec3, f32) {
    if side == face {
        (FACES[face], FRONT_ANGLE)
    } else {
        ((FACES[face] + 0.5 * FACES[side]).normalize(), SIDE_ANGLE)
    }
}

/// Light that leaves a voxel in a step, per face and per face of the neighbour behind it; 0 for the
/// face between the two.
struct Leaving {
    parts: [[Vec3; 6]; 6],
}

impl Leaving {
    /// `None` without light.
    fn new(intensity: &Intensity) -> Option<Self> {
        let total = Vec3::from_array(intensity.map(flux)).max(Vec3::ZERO);
        if total == Vec3::ZERO {
            return None;
        }
        let mut sum = Vec3::ZERO;
        let mut parts = [[Vec3::ZERO; 6]; 6];
        for (face, parts) in parts.iter_mut().enumerate() {
            for (side, part) in parts.iter_mut().enumerate() {
                if side == face ^ 1 {
                    continue;
                }
                let (direction, angle) = travel(face, side);
                let basis = basis(direction);
                *part = Vec3::from_array(intensity.map(|c| c.dot(basis).max(0.0))) * angle;
                sum += *part;
            }
        }
        let scale = total * KEPT / sum.max(Vec3::splat(f32::MIN_POSITIVE));
        for part in parts.iter_mut().flatten() {
            *part *= scale;
        }
        Some(Self { parts })
    }
}

/// Adds a cosine lobe with this flux.
fn add(intensity: &mut Intensity, flux: Vec3, normal: Vec3) {
    let lobe = cosine_lobe(normal) / PI;
    for (channel, flux) in intensity.iter_mut().zip(flux.to_array()) {
        *channel += lobe * flux;
    }
}

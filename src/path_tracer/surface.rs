//! Surfaces, what they reflect, and their specular lobe: GGX microfacets without multiple scattering, as Bevy shades them.

use std::f32::consts::{FRAC_1_PI, PI, TAU};

use bevy::math::{Vec2, Vec3};

use crate::path_tracer::{Random, cosine_direction};

/// How far a ray starts above the surface that it leaves, in metres.
pub(super) const OFFSET: f32 = 1e-4;

/// The surfaces of a scene.
pub trait Surfaces: Sync {
    /// The first surface that a ray hits.
    fn closest(&self, ray: Ray) -> Option<Hit>;

    /// Whether a ray hits a surface within this distance.
    fn blocked(&self, ray: Ray, distance: f32) -> bool;

    /// Area of all emissive surfaces in square metres.
    fn emissive_area(&self) -> f32 {
        0.0
    }

    /// A point of the emissive surfaces, uniform over their area, from three numbers between 0 and 1.
    fn sample_light(&self, _at: [f32; 3]) -> Option<LightSample> {
        None
    }
}

/// A half line.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Origin in metres.
    pub origin: Vec3,
    /// A unit vector.
    pub direction: Vec3,
}

/// A point of a surface.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    /// Its distance from the origin of the ray, in metres.
    pub distance: f32,
    /// The point, in metres.
    pub position: Vec3,
    /// The normal of the geometry on the side of the ray, a unit vector.
    pub face_normal: Vec3,
    /// The normal that light is reflected about, a unit vector.
    pub normal: Vec3,
    /// Diffuse albedo per channel, 0 to 1.
    pub albedo: Vec3,
    /// The specular lobe, if there is one.
    pub gloss: Option<Gloss>,
    /// Radiance that the surface emits, in cd/m².
    pub emission: Vec3,
}

impl Hit {
    /// A ray that leaves the surface.
    pub(super) fn ray(&self, direction: Vec3) -> Ray {
        Ray {
            origin: self.position + OFFSET * self.face_normal,
            direction,
        }
    }

    /// Radiance that each lobe reflects to the viewer per illuminance from a direction.
    pub(super) fn brdf(&self, to_viewer: Vec3, direction: Vec3) -> Reflected {
        Reflected {
            diffuse: self.albedo / PI,
            specular: self.gloss.map_or(Vec3::ZERO, |gloss| {
                gloss.brdf(self.normal, to_viewer, direction)
            }),
        }
    }

    /// The probability with which directions are sampled from the specular lobe.
    fn specular_share(&self) -> f32 {
        match self.gloss {
            None => 0.0,
            Some(_) if self.albedo == Vec3::ZERO => 1.0,
            Some(_) => 0.5,
        }
    }

    /// The density of sampled directions, per steradian.
    pub(super) fn pdf(&self, to_viewer: Vec3, direction: Vec3) -> f32 {
        let diffuse = self.normal.dot(direction) * FRAC_1_PI;
        match self.gloss {
            None => diffuse,
            Some(gloss) => {
                let specular = gloss.pdf(self.normal, to_viewer, direction);
                diffuse + self.specular_share() * (specular - diffuse)
            }
        }
    }

    /// Samples a direction, from the diffuse lobe by a point of the unit square; `None` if it does not leave the surface.
    pub(super) fn scatter(
        &self,
        to_viewer: Vec3,
        at: Vec2,
        random: &mut Random,
    ) -> Option<Scattered> {
        let Some(gloss) = self.gloss else {
            let direction = cosine_direction(self.normal, at);
            return Some(Scattered {
                direction,
                pdf: self.normal.dot(direction) * FRAC_1_PI,
                reflected: Reflected {
                    diffuse: self.albedo,
                    specular: Vec3::ZERO,
                },
            });
        };
        let direction = if random.unit() < self.specular_share() {
            gloss.sample(self.normal, to_viewer, at)?
        } else {
            cosine_direction(self.normal, at)
        };
        let pdf = self.pdf(to_viewer, direction);
        let mut reflected = Reflected::default();
        let weight = Vec3::splat(self.normal.dot(direction) / pdf.max(1e-6));
        reflected.add(self.brdf(to_viewer, direction), weight);
        Some(Scattered {
            direction,
            pdf,
            reflected,
        })
    }

    /// About the share of light that it reflects, for Russian roulette.
    pub(super) fn albedo_of_all(&self, to_viewer: Vec3) -> Vec3 {
        let Some(gloss) = self.gloss else {
            return self.albedo;
        };
        let grazing = (1.0 - self.normal.dot(to_viewer).clamp(0.0, 1.0)).powi(5);
        self.albedo + gloss.f0 + (1.0 - gloss.f0) * grazing
    }
}

/// What the lobes of a surface reflect: radiance, or a share of it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Reflected {
    pub diffuse: Vec3,
    pub specular: Vec3,
}

impl Reflected {
    pub fn total(self) -> Vec3 {
        self.diffuse + self.specular
    }

    pub fn add(&mut self, brdf: Self, illuminance: Vec3) {
        self.diffuse += brdf.diffuse * illuminance;
        self.specular += brdf.specular * illuminance;
    }
}

/// A sampled direction in which a path goes on.
pub(super) struct Scattered {
    pub direction: Vec3,
    /// Its density per steradian.
    pub pdf: f32,
    /// The shares of the light from there that are reflected, over its density.
    pub reflected: Reflected,
}

/// A point of an emissive surface.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// The point, in metres.
    pub position: Vec3,
    /// The normal of its side that emits, a unit vector.
    pub normal: Vec3,
    /// Radiance that it emits, in cd/m².
    pub emission: Vec3,
}

/// A specular lobe on top of a surface's diffuse one, from which it takes no light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gloss {
    /// Perceptual roughness, 0.089 to 1, whose square is the width of GGX (as Bevy has it).
    pub roughness: f32,
    /// Reflectance per channel at normal incidence, 0 to 1; at least 0.02 where there is any.
    pub f0: Vec3,
}

impl Gloss {
    fn alpha(&self) -> f32 {
        self.roughness.clamp(0.089, 1.0).powi(2)
    }

    /// Radiance that is reflected to the viewer per illuminance from a direction; both directions leave the surface.
    pub fn brdf(&self, normal: Vec3, to_viewer: Vec3, direction: Vec3) -> Vec3 {
        let half = (to_viewer + direction).normalize_or(normal);
        let (n_v, n_l) = (cosine(normal, to_viewer), cosine(normal, direction));
        let alpha2 = self.alpha().powi(2);
        let masked = |a: f32, b: f32| a * (b * b * (1.0 - alpha2) + alpha2).sqrt();
        // Height-correlated Smith shadowing over 4 n_v n_l.
        let shadowing = 0.5 / (masked(n_l, n_v) + masked(n_v, n_l));
        let fresnel = self.f0 + (1.0 - self.f0) * (1.0 - cosine(to_viewer, half)).powi(5);
        self.distribution(normal.dot(half)) * shadowing * fresnel
    }

    /// A direction from a point of the unit square, by the microfacets that the viewer sees; `None` if it does not leave
    /// the surface (J. Dupuy and A. Benyoub, *Sampling Visible GGX Normals with Spherical Caps*, 2023).
    pub fn sample(&self, normal: Vec3, to_viewer: Vec3, at: Vec2) -> Option<Vec3> {
        let alpha = self.alpha();
        let (tangent, bitangent) = normal.any_orthonormal_pair();
        let local = |v: Vec3| Vec3::new(v.dot(tangent), v.dot(bitangent), v.dot(normal));
        let stretch = Vec3::new(alpha, alpha, 1.0);
        let seen = (local(to_viewer).max(Vec3::new(-1.0, -1.0, 1e-4)) * stretch).normalize();
        let z = (1.0 - at.y) * (1.0 + seen.z) - seen.z;
        let (sin, cos) = (TAU * at.x).sin_cos();
        let radius = (1.0 - z * z).max(0.0).sqrt();
        let half = (Vec3::new(radius * cos, radius * sin, z) + seen) * stretch;
        let half = half.normalize_or(Vec3::Z);
        let half = half.x * tangent + half.y * bitangent + half.z * normal;
        let direction = (2.0 * to_viewer.dot(half) * half - to_viewer).normalize();
        (normal.dot(direction) > 0.0).then_some(direction)
    }

    /// The density of these directions per steradian.
    pub fn pdf(&self, normal: Vec3, to_viewer: Vec3, direction: Vec3) -> f32 {
        let half = (to_viewer + direction).normalize_or(normal);
        let n_v = cosine(normal, to_viewer);
        let alpha2 = self.alpha().powi(2);
        // Of Smith's visible share, 2 n_v cancels against the Jacobian.
        let visible = n_v + (alpha2 + (1.0 - alpha2) * n_v * n_v).sqrt();
        self.distribution(normal.dot(half)) / (2.0 * visible)
    }

    /// The density of microfacets whose normals have this cosine to the surface's.
    fn distribution(&self, cosine: f32) -> f32 {
        let alpha2 = self.alpha().powi(2);
        alpha2 / (PI * (cosine * cosine * (alpha2 - 1.0) + 1.0).powi(2))
    }
}

fn cosine(a: Vec3, b: Vec3) -> f32 {
    a.dot(b).clamp(1e-4, 1.0)
}

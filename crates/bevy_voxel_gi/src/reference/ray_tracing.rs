//! Light gathered by ray tracing, bounce after bounce (thesis 6.6.1), and the ambient occlusion of short
//! rays (thesis 6.7).
//!
//! Unlike in the thesis, rays start on surfaces, about their normals, and the result is stored as the
//! irradiance of each surface instead of spherical harmonics of the voxel: no light leaks through the
//! surface from its other side, and no rays are wasted on the far hemisphere.

use super::{
    each,
    gather::{hemisphere, sphere},
    irradiance_field::IrradianceField,
    light::{Light, direct_light},
    share::shared_light,
    surface::{Surface, surfaces},
    trace::{RaySample, hit_radiance, trace},
    voxels::{Material, Voxels},
};
use glam::{Vec3, Vec4};
use std::f32::consts::PI;

/// Number of frames after a start in which bounces propagate before averaging starts.
pub const WARM_UP: u32 = 4;

/// Number of frames after a change in which the rays begin with their first set.
pub const REST: u32 = 8;

/// Number of frames from then until a new mean begins, in which the light that bounces becomes that of the new rays.
pub const BOUNCES: u32 = 8;

/// Number of frames after a change in which the light settles.
pub const SETTLE: u32 = REST + BOUNCES + 32;

/// Greatest number of frames in the mean.
pub const LONGEST_MEAN: u32 = 64;

/// Settings of the ray tracing solver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayTracingSettings {
    /// Number of rays of a surface per frame, at least 1.
    pub rays: u32,
    /// Number of rays of an empty voxel per frame; 0 leaves it dark.
    pub empty_rays: u32,
    /// Number of points of a surface that are tested for shadow, per light, 1 to 16.
    pub shadow_points: u32,
    /// Weight of an empty voxel where receivers interpolate; surfaces have 1.
    pub empty_weight: f32,
    /// Longest ray, in voxels; beyond it is the sky.
    pub reach: f32,
    /// Number of frames over which receivers read the mean, at least 1, until the new mean begins, [`REST`] and
    /// [`BOUNCES`] after the last change: that grows to [`LONGEST_MEAN`].
    pub history: u32,
    /// Whether receivers test which voxels are visible ([`IrradianceField::visible_irradiance`]).
    pub tests_visibility: bool,
    /// Whether neighbouring surfaces of a plane share their light.
    pub shares: bool,
}

impl Default for RayTracingSettings {
    fn default() -> Self {
        Self {
            rays: 32,
            empty_rays: 32,
            shadow_points: 16,
            empty_weight: 1.0 / 512.0,
            reach: f32::INFINITY,
            history: 8,
            tests_visibility: false,
            shares: true,
        }
    }
}

/// The ray tracing solver and its state.
pub struct RayTracing<'a> {
    voxels: &'a Voxels,
    /// Per voxel: the material of each face.
    materials: Vec<[Material; 6]>,
    sky: Vec3,
    settings: RayTracingSettings,
    /// The surfaces of the voxels.
    pub surfaces: Vec<Surface>,
    /// Per surface: direct irradiance, in lux.
    pub direct: Vec<Vec3>,
    /// Per surface: indirect irradiance in the last frame, in lux.
    pub indirect: Vec<Vec3>,
    /// Per surface: mean over frames of the indirect irradiance times the fraction of valid samples, and
    /// of that fraction.
    pub mean: Vec<Vec4>,
    /// Per voxel and face: radiance of its surface, in cd/m^2.
    pub radiance: Vec<[Vec3; 6]>,
    /// Number of the frame, which determines the directions of rays. Each frame has one bounce.
    pub frame: u32,
    /// Number of frames since the lights were changed.
    since_change: u32,
    /// Number of frames in the mean, those of the warm-up included.
    mean_frames: u32,
}

impl<'a> RayTracing<'a> {
    /// Creates the state with direct light only. `sky` is the radiance from outside the volume, in
    /// cd/m^2.
    pub fn new(
        voxels: &'a Voxels,
        materials: &[Material],
        lights: &[Light],
        sky: Vec3,
        settings: RayTracingSettings,
    ) -> Self {
        let surfaces = surfaces(voxels, settings.tests_visibility);
        let mut ray_tracing = Self {
            voxels,
            materials: face_materials(voxels, materials),
            sky,
            settings,
            direct: Vec::new(),
            indirect: vec![Vec3::ZERO; surfaces.len()],
            mean: vec![Vec4::ZERO; surfaces.len()],
            radiance: vec![[Vec3::ZERO; 6]; voxels.grid.len()],
            surfaces,
            frame: 0,
            since_change: 0,
            mean_frames: 0,
        };
        ray_tracing.set_lights(lights);
        ray_tracing
    }

    /// Replaces the lights: the next frame is lit by these.
    pub fn set_lights(&mut self, lights: &[Light]) {
        self.since_change = 0;
        self.direct = each(self.surfaces.len(), |i| {
            direct_light(
                self.voxels,
                &self.surfaces[i],
                lights,
                self.settings.shadow_points,
            )
        });
        self.reflect();
    }

    /// Updates the radiance of every surface from its irradiance.
    fn reflect(&mut self) {
        for (i, surface) in self.surfaces.iter().enumerate() {
            let irradiance = self.direct[i] + self.indirect[i];
            for face in surface.faces() {
                let material = self.materials[surface.voxel][face];
                self.radiance[surface.voxel][face] =
                    material.emission + material.albedo * irradiance / PI;
            }
        }
    }

    /// Computes one more frame, with one bounce.
    ///
    /// Bounces use the irradiance of the last frame, receivers the mean: if bounces used the mean, each
    /// would take as many frames as the mean.
    pub fn step(&mut self) {
        let new = each(self.surfaces.len(), |i| {
            let arriving = |o, d| self.arriving(o, d);
            hemisphere(&self.surfaces[i], self.settings.rays, self.frame, arriving)
        });
        let most = if self.since_change < REST + BOUNCES {
            self.settings.history
        } else {
            LONGEST_MEAN
        };
        let frames = (self.mean_frames + 1).saturating_sub(WARM_UP);
        let keep = 1.0 - 1.0 / frames.clamp(1, most.max(1)) as f32;
        self.advance();
        for (i, new) in new.into_iter().enumerate() {
            // Without a valid sample the old value is kept.
            if new.w > 0.0 {
                self.indirect[i] = new.truncate() * PI / new.w;
            }
            let new = (new.truncate() * PI).extend(new.w);
            self.mean[i] = new.lerp(self.mean[i], keep);
        }
        self.reflect();
    }

    /// Begins with the first rays once nothing has changed for a while, and with a new mean once the bounces of
    /// the former rays have faded: so the same scene always settles to the same light.
    fn advance(&mut self) {
        self.frame += 1;
        self.since_change += 1;
        self.mean_frames += 1;
        if self.since_change == REST {
            self.frame = 0;
        }
        if self.since_change == REST + BOUNCES {
            self.mean_frames = WARM_UP;
        }
    }

    /// Returns the radiance that arrives along a ray.
    pub fn arriving(&self, origin: Vec3, direction: Vec3) -> RaySample<Vec3> {
        let Some(hit) = trace(self.voxels, origin, direction, self.settings.reach) else {
            return RaySample::Light(self.sky);
        };
        hit_radiance(self.voxels, &hit, direction, |voxel, face| {
            self.radiance[voxel][face]
        })
    }

    /// Returns the field that receivers sample: irradiance, in lux.
    pub fn field(&self) -> IrradianceField {
        let RayTracingSettings {
            empty_rays,
            empty_weight,
            ..
        } = self.settings;
        let mut field = surround(self.voxels, empty_rays, empty_weight, |o, d| {
            self.arriving(o, d).map(|radiance| radiance * PI)
        });
        let light = if self.settings.shares {
            &shared_light(self.voxels, &self.surfaces, &self.mean)
        } else {
            &self.mean
        };
        field.put(&self.surfaces, light);
        field
    }
}

/// Creates the solver of ambient occlusion: all surfaces are black, and receive the light of a sky from where they have
/// no obstacle within `radius` voxels (thesis Eq. 6.17). With a `sky` of 1 / pi, the irradiance of a surface is its
/// ambient visibility, 1 where it is open.
pub fn ambient_occlusion(
    voxels: &Voxels,
    sky: Vec3,
    radius: f32,
    settings: RayTracingSettings,
) -> RayTracing<'_> {
    let settings = RayTracingSettings {
        reach: radius,
        // Occlusion changes within its radius, which may be a few voxels: sharing would blur it.
        shares: false,
        ..settings
    };
    RayTracing::new(voxels, &[], &[], sky, settings)
}

/// The field of the empty voxels.
fn surround(
    voxels: &Voxels,
    rays: u32,
    weight: f32,
    arriving: impl Fn(Vec3, Vec3) -> RaySample<Vec3> + Sync,
) -> IrradianceField {
    let grid = voxels.grid;
    let texels = each(grid.len(), |voxel| {
        if voxels.masks[voxel] != 0 {
            return [Vec4::ZERO; 6];
        }
        let voxel = grid.voxel(voxel);
        let center = voxel.as_vec3() + 0.5;
        sphere(grid.seed_in_world(voxel), center, rays, weight, &arriving)
    });
    IrradianceField { grid, texels }
}

/// Returns the material of each face of each voxel.
pub(super) fn face_materials(voxels: &Voxels, materials: &[Material]) -> Vec<[Material; 6]> {
    each(voxels.grid.len(), |index| {
        [0, 1, 2, 3, 4, 5].map(|face| voxels.face_material(index, face, materials))
    })
}

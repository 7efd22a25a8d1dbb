//! Paths of light.

use std::f32::consts::{FRAC_1_PI, PI};

use bevy::math::{Vec2, Vec3};

use super::{
    random::{Random, cosine_direction},
    surfaces::{Hit, OFFSET, Surfaces},
};
use crate::stage::Stage;

/// How well light is traced.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TraceSettings {
    /// Paths from each pixel or receiver, at least 1. Default 256; noise falls with its square root.
    pub samples: u32,
    /// Most segments of a path, a camera's ray included, at least 2. Default 24.
    pub depth: u32,
    /// Another one gives another noise. Default 0.
    pub seed: u32,
}

impl Default for TraceSettings {
    fn default() -> Self {
        Self {
            samples: 256,
            depth: 24,
            seed: 0,
        }
    }
}

/// Segments of a path before it may end at random.
const SURE_DEPTH: u32 = 4;

/// Traces paths through a scene.
pub(super) struct Tracer<'a, S> {
    pub surfaces: &'a S,
    pub stage: &'a Stage,
    pub settings: TraceSettings,
    emissive_area: f32,
}

impl<'a, S: Surfaces> Tracer<'a, S> {
    pub fn new(surfaces: &'a S, stage: &'a Stage, settings: &TraceSettings) -> Self {
        Self {
            surfaces,
            stage,
            settings: TraceSettings {
                samples: settings.samples.max(1),
                depth: settings.depth.max(2),
                ..*settings
            },
            emissive_area: surfaces.emissive_area(),
        }
    }

    /// Radiance that a surface reflects of point and directional lights, without detours.
    pub fn direct(&self, hit: &Hit) -> Vec3 {
        hit.albedo / PI * self.lit(hit)
    }

    /// Radiance that a surface reflects of all else, by one path whose first direction is a point of the unit
    /// square.
    pub fn indirect(&self, hit: Hit, first: Vec2, random: &mut Random) -> Vec3 {
        let emitted = hit.albedo / PI * self.lit_by_surfaces(&hit, random);
        emitted + self.bounced(hit, first, random)
    }

    /// Radiance that a surface has from other surfaces and the sky, by one path, without what sampling the
    /// emissive surfaces brings to its first point.
    fn bounced(&self, mut hit: Hit, first: Vec2, random: &mut Random) -> Vec3 {
        let mut sum = Vec3::ZERO;
        let mut throughput = hit.albedo;
        let mut first = Some(first);
        for depth in 2..=self.settings.depth {
            let at = first
                .take()
                .unwrap_or_else(|| Vec2::new(random.unit(), random.unit()));
            let direction = cosine_direction(hit.normal, at);
            let cosine = hit.normal.dot(direction);
            match self.surfaces.closest(hit.ray(direction)) {
                None => return sum + throughput * self.stage.sky_radiance,
                Some(next) => hit = next,
            }
            if hit.emission != Vec3::ZERO {
                let sampled = self.emitter_density(&hit, direction);
                let found = cosine * FRAC_1_PI;
                sum += throughput * hit.emission * found / (found + sampled);
            }
            if depth < self.settings.depth {
                let light = self.lit(&hit) + self.lit_by_surfaces(&hit, random);
                sum += throughput * hit.albedo / PI * light;
            }
            throughput *= hit.albedo;
            let likely = throughput.max_element().min(0.95);
            if likely <= 0.0 {
                break;
            }
            if depth >= SURE_DEPTH {
                if random.unit() >= likely {
                    break;
                }
                throughput /= likely;
            }
        }
        sum
    }

    /// Illuminance by point and directional lights in lux.
    fn lit(&self, hit: &Hit) -> Vec3 {
        let mut sum = Vec3::ZERO;
        for light in &self.stage.point_lights {
            let to_light = light.position - hit.position;
            let distance = to_light.length();
            let direction = to_light / distance;
            let cosine = hit.normal.dot(direction);
            if cosine > 0.0 && !self.surfaces.blocked(hit.ray(direction), distance) {
                sum += light.intensity_cd * cosine / (distance * distance);
            }
        }
        for sun in &self.stage.directional_lights {
            let direction = -sun.direction.normalize();
            let cosine = hit.normal.dot(direction);
            if cosine > 0.0 && !self.surfaces.blocked(hit.ray(direction), f32::INFINITY) {
                sum += sun.illuminance_lux * cosine;
            }
        }
        sum
    }

    /// Illuminance in lux by a sampled point of the emissive surfaces, weighted against finding it by chance.
    fn lit_by_surfaces(&self, hit: &Hit, random: &mut Random) -> Vec3 {
        if self.emissive_area <= 0.0 || hit.albedo == Vec3::ZERO {
            return Vec3::ZERO;
        }
        let at = [random.unit(), random.unit(), random.unit()];
        let Some(point) = self.surfaces.emitter(at) else {
            return Vec3::ZERO;
        };
        let to_point = point.position - hit.position;
        let distance = to_point.length();
        let direction = to_point / distance;
        let (cosine, emitted) = (hit.normal.dot(direction), -point.normal.dot(direction));
        if cosine <= 0.0 || emitted <= 0.0 || distance <= 2.0 * OFFSET {
            return Vec3::ZERO;
        }
        if self
            .surfaces
            .blocked(hit.ray(direction), distance - 2.0 * OFFSET)
        {
            return Vec3::ZERO;
        }
        let sampled = distance * distance / (emitted * self.emissive_area);
        let found = cosine * FRAC_1_PI;
        point.emission * cosine / (sampled + found)
    }

    /// The density of directions, per steradian, with which a hit is sampled as a point that emits.
    fn emitter_density(&self, hit: &Hit, direction: Vec3) -> f32 {
        let emitted = -hit.face_normal.dot(direction);
        hit.distance * hit.distance / (emitted.max(1e-6) * self.emissive_area)
    }
}

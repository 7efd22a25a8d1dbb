//! Traced pictures.

use std::f32::consts::{FRAC_1_PI, PI};

use bevy::math::{Vec2, Vec3};
use rayon::prelude::*;

use super::{
    random::{Random, cosine_direction, unit},
    surfaces::{Hit, OFFSET, Surfaces},
    view::View,
};
use crate::stage::Stage;

/// How well a picture is traced.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TraceSettings {
    /// Paths from each pixel, at least 1. Default 256; noise falls with its square root.
    pub samples: u32,
    /// Most segments of a path, the camera's ray included, at least 2. Default 24.
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

/// Radiance of each pixel, row after row from the top left.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TracedPicture {
    /// Width in pixels.
    pub width: u32,
    /// All light.
    pub total: Vec<Vec3>,
    /// What visible surfaces reflect of point and directional lights, without detours.
    pub direct: Vec<Vec3>,
    /// All else that visible surfaces reflect: light of other surfaces, those that emit included, and of the
    /// sky. What visible surfaces emit themselves is only in `total`; 0 where no surface is seen.
    pub indirect: Vec<Vec3>,
}

/// The scene as its camera sees it, traced on all cores.
pub fn trace(surfaces: &impl Surfaces, stage: &Stage, settings: &TraceSettings) -> TracedPicture {
    let tracer = Tracer {
        surfaces,
        stage,
        settings: TraceSettings {
            samples: settings.samples.max(1),
            depth: settings.depth.max(2),
            ..*settings
        },
        view: View::new(&stage.camera),
        emissive_area: surfaces.emissive_area(),
    };
    let (width, height) = (stage.camera.width, stage.camera.height);
    let pixels: Vec<Pixel> = (0..width * height)
        .into_par_iter()
        .map(|index| tracer.pixel(index % width, index / width))
        .collect();
    TracedPicture {
        width,
        total: pixels.iter().map(|p| p.total).collect(),
        direct: pixels.iter().map(|p| p.direct).collect(),
        indirect: pixels.iter().map(|p| p.indirect).collect(),
    }
}

/// Segments of a path before it may end at random.
const SURE_DEPTH: u32 = 4;

#[derive(Clone, Copy, Default)]
struct Pixel {
    total: Vec3,
    direct: Vec3,
    indirect: Vec3,
}

struct Tracer<'a, S> {
    surfaces: &'a S,
    stage: &'a Stage,
    settings: TraceSettings,
    view: View,
    emissive_area: f32,
}

impl<S: Surfaces> Tracer<'_, S> {
    fn pixel(&self, x: u32, y: u32) -> Pixel {
        let index = y * self.stage.camera.width + x;
        let mut start = Random::new(index, u32::MAX, self.settings.seed);
        let offset = [start.bits(), start.bits()];
        let mut sum = Pixel::default();
        for sample in 0..self.settings.samples {
            let mut random = Random::new(index, sample, self.settings.seed);
            let at = Vec2::new(x as f32 + random.unit(), y as f32 + random.unit());
            let Some(hit) = self.surfaces.closest(self.view.ray(at)) else {
                sum.total += self.stage.sky_radiance;
                continue;
            };
            // First directions are spread evenly over the samples of a pixel (the R2 sequence).
            let [a, b] = [3_242_174_889_u32, 2_447_445_414].map(|step| step.wrapping_mul(sample));
            let spread = Vec2::new(
                unit(a.wrapping_add(offset[0])),
                unit(b.wrapping_add(offset[1])),
            );
            let direct = hit.albedo / PI * self.lit(&hit);
            let emitted = hit.albedo / PI * self.lit_by_surfaces(&hit, &mut random);
            let indirect = emitted + self.bounced(hit, spread, &mut random);
            sum.direct += direct;
            sum.indirect += indirect;
            sum.total += hit.emission + direct + indirect;
        }
        let scale = 1.0 / self.settings.samples as f32;
        Pixel {
            total: scale * sum.total,
            direct: scale * sum.direct,
            indirect: scale * sum.indirect,
        }
    }

    /// Radiance that a surface has from other surfaces and the sky, by one path, without what sampling the
    /// emissive surfaces brings to its first point.
    fn bounced(&self, mut hit: Hit, spread: Vec2, random: &mut Random) -> Vec3 {
        let mut sum = Vec3::ZERO;
        let mut throughput = hit.albedo;
        let mut spread = Some(spread);
        for depth in 2..=self.settings.depth {
            let at = spread
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

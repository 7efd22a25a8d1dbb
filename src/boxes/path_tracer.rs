//! Path tracing of a scene of boxes on the CPU: the truth where none is at hand.
//!
//! Surfaces are Lambertian, lamps are sampled directly, the sky is what rays find that leave the
//! scene. The same settings give the same picture on any number of threads.

use std::f32::consts::{PI, TAU};

use bevy::math::{Mat3, Vec2, Vec3};
use rayon::prelude::*;

use super::{BoxScene, SceneBox};

pub(super) mod walls;

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
    /// What reaches a visible surface straight from a lamp.
    pub direct: Vec<Vec3>,
    /// All the rest from surfaces, the sky's first arrival included; 0 where no surface is seen.
    pub indirect: Vec<Vec3>,
}

/// The scene as its camera sees it, traced on all cores.
pub fn trace(scene: &BoxScene, settings: &TraceSettings) -> TracedPicture {
    let tracer = Tracer::new(scene, *settings);
    let (width, height) = (scene.camera.width, scene.camera.height);
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

/// How far a ray starts above the surface that it leaves, in metres.
const OFFSET: f32 = 1e-4;
/// Segments of a path before it may end at random.
const SURE_DEPTH: u32 = 4;

#[derive(Clone, Copy, Default)]
struct Pixel {
    total: Vec3,
    direct: Vec3,
    indirect: Vec3,
}

#[derive(Clone, Copy)]
struct Ray {
    origin: Vec3,
    direction: Vec3,
}

#[derive(Clone, Copy)]
struct Hit {
    position: Vec3,
    normal: Vec3,
    albedo: Vec3,
}

impl Hit {
    fn ray(&self, direction: Vec3) -> Ray {
        Ray {
            origin: self.position + OFFSET * self.normal,
            direction,
        }
    }
}

struct Solid {
    center: Vec3,
    half: Vec3,
    albedo: Vec3,
    /// From its axes to those of the world.
    axes: Mat3,
}

impl Solid {
    fn new(part: &SceneBox) -> Self {
        Self {
            center: part.center,
            half: part.half,
            albedo: part.albedo,
            axes: Mat3::from_quat(part.rotation()),
        }
    }

    /// Distances at which the ray enters and leaves, and per axis where it enters, in its axes.
    fn span(&self, ray: Ray) -> Option<(f32, f32, Vec3, Vec3)> {
        let origin = self.axes.transpose() * (ray.origin - self.center);
        let direction = self.axes.transpose() * ray.direction;
        // No slab is parallel to the ray, so that no distance is 0 times infinity.
        let direction = direction.map(|d| if d.abs() < 1e-12 { 1e-12 } else { d });
        let (a, b) = (
            (-self.half - origin) / direction,
            (self.half - origin) / direction,
        );
        let enter = a.min(b);
        let (near, far) = (enter.max_element(), a.max(b).min_element());
        (near <= far && far > 0.0).then_some((near, far, enter, direction))
    }

    /// Distance and normal, in the world. From inside, a box is black: nobody looks at it there.
    fn hit(&self, ray: Ray) -> Option<(f32, Vec3, Vec3)> {
        let (near, far, enter, direction) = self.span(ray)?;
        if near <= 0.0 {
            return Some((far, -ray.direction, Vec3::ZERO));
        }
        let axis = enter.max_position();
        let mut normal = Vec3::ZERO;
        normal[axis] = -direction[axis].signum();
        Some((near, self.axes * normal, self.albedo))
    }
}

struct Tracer<'a> {
    scene: &'a BoxScene,
    settings: TraceSettings,
    solids: Vec<Solid>,
    /// The camera's right, up and forward, the first two half as long as the picture at distance 1.
    view: Mat3,
}

impl<'a> Tracer<'a> {
    fn new(scene: &'a BoxScene, settings: TraceSettings) -> Self {
        let camera = scene.camera;
        let forward = (camera.target - camera.eye).normalize();
        let right = forward.cross(camera.up).normalize();
        let half_height = (0.5 * camera.fov_y_deg.to_radians()).tan();
        let half_width = half_height * camera.width as f32 / camera.height as f32;
        Self {
            scene,
            settings: TraceSettings {
                samples: settings.samples.max(1),
                depth: settings.depth.max(2),
                ..settings
            },
            solids: scene.boxes.iter().map(Solid::new).collect(),
            view: Mat3::from_cols(
                right * half_width,
                right.cross(forward) * half_height,
                forward,
            ),
        }
    }

    fn pixel(&self, x: u32, y: u32) -> Pixel {
        let camera = self.scene.camera;
        let size = Vec2::new(camera.width as f32, camera.height as f32);
        let index = y * camera.width + x;
        let mut start = Random::new(index, u32::MAX, self.settings.seed);
        let offset = [start.bits(), start.bits()];
        let mut sum = Pixel::default();
        for sample in 0..self.settings.samples {
            let mut random = Random::new(index, sample, self.settings.seed);
            let at = Vec2::new(x as f32 + random.unit(), y as f32 + random.unit()) / size;
            let at = Vec2::new(2.0 * at.x - 1.0, 1.0 - 2.0 * at.y);
            let ray = Ray {
                origin: camera.eye,
                direction: (self.view * at.extend(1.0)).normalize(),
            };
            let Some(hit) = self.closest(ray) else {
                sum.total += self.scene.sky_radiance;
                continue;
            };
            // First directions are spread evenly over the samples of a pixel (the R2 sequence).
            let [a, b] = [3_242_174_889_u32, 2_447_445_414].map(|step| step.wrapping_mul(sample));
            let spread = Vec2::new(
                unit(a.wrapping_add(offset[0])),
                unit(b.wrapping_add(offset[1])),
            );
            let direct = hit.albedo / PI * self.lit(&hit);
            let indirect = self.bounced(hit, spread, &mut random);
            sum.direct += direct;
            sum.indirect += indirect;
            sum.total += direct + indirect;
        }
        let scale = 1.0 / self.settings.samples as f32;
        Pixel {
            total: scale * sum.total,
            direct: scale * sum.direct,
            indirect: scale * sum.indirect,
        }
    }

    /// Radiance that a surface has from other surfaces and the sky, by one path.
    fn bounced(&self, mut hit: Hit, spread: Vec2, random: &mut Random) -> Vec3 {
        let mut sum = Vec3::ZERO;
        let mut throughput = hit.albedo;
        let mut spread = Some(spread);
        for depth in 2..=self.settings.depth {
            let at = spread
                .take()
                .unwrap_or_else(|| Vec2::new(random.unit(), random.unit()));
            let ray = hit.ray(cosine_direction(hit.normal, at));
            match self.closest(ray) {
                None => return sum + throughput * self.scene.sky_radiance,
                Some(next) => hit = next,
            }
            if depth < self.settings.depth {
                sum += throughput * hit.albedo / PI * self.lit(&hit);
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

    /// Illuminance by lamps in lux.
    fn lit(&self, hit: &Hit) -> Vec3 {
        let mut sum = Vec3::ZERO;
        for lamp in &self.scene.point_lights {
            let way = lamp.position - hit.position;
            let distance = way.length();
            let direction = way / distance;
            let cosine = hit.normal.dot(direction);
            if cosine > 0.0 && !self.blocked(hit.ray(direction), distance) {
                sum += lamp.intensity_cd * cosine / (distance * distance);
            }
        }
        for sun in &self.scene.directional_lights {
            let direction = -sun.direction.normalize();
            let cosine = hit.normal.dot(direction);
            if cosine > 0.0 && !self.blocked(hit.ray(direction), f32::INFINITY) {
                sum += sun.illuminance_lux * cosine;
            }
        }
        sum
    }

    fn blocked(&self, ray: Ray, distance: f32) -> bool {
        self.solids.iter().any(|solid| {
            let span = solid.span(ray);
            span.is_some_and(|(near, far, ..)| if near > 0.0 { near } else { far } < distance)
        })
    }

    fn closest(&self, ray: Ray) -> Option<Hit> {
        let hits = self.solids.iter().filter_map(|solid| solid.hit(ray));
        let (distance, normal, albedo) = hits.min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(Hit {
            position: ray.origin + distance * ray.direction,
            normal,
            albedo,
        })
    }
}

/// A direction around a normal, as likely as its cosine is large, from a point of the unit square.
fn cosine_direction(normal: Vec3, at: Vec2) -> Vec3 {
    let (sin, cos) = (TAU * at.x).sin_cos();
    let radius = at.y.sqrt();
    let (tangent, bitangent) = normal.any_orthonormal_pair();
    radius * (cos * tangent + sin * bitangent) + (1.0 - at.y).max(0.0).sqrt() * normal
}

/// Numbers that look random: the same for the same path of the same pixel (PCG).
struct Random(u32);

impl Random {
    fn new(pixel: u32, sample: u32, seed: u32) -> Self {
        let mut state = Self(seed);
        for part in [pixel, sample] {
            state.0 = state.bits() ^ part;
        }
        state.bits();
        state
    }

    fn bits(&mut self) -> u32 {
        self.0 = self.0.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        let word = ((self.0 >> ((self.0 >> 28) + 4)) ^ self.0).wrapping_mul(277_803_737);
        (word >> 22) ^ word
    }

    /// From 0 to below 1.
    fn unit(&mut self) -> f32 {
        unit(self.bits())
    }
}

fn unit(bits: u32) -> f32 {
    (bits >> 8) as f32 / (1 << 24) as f32
}

#[cfg(test)]
mod tests;

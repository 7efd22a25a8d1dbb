//! Path tracing on the CPU: the light that others are compared with.
//!
//! Surfaces are Lambertian, and may have a specular lobe of GGX microfacets besides. Next-event estimation samples the lights at each point of a path: all point and directional
//! ones, and a point of the emissive surfaces, which paths hit by chance, too, with the weights of multiple importance
//! sampling (balance heuristic: E. Veach, *Robust Monte Carlo Methods for Light Transport Simulation*, 1997,
//! section 9.2.2). Rays that leave the scene hit the sky. Russian roulette ends paths. The same settings give the same picture on any number of
//! threads.

use std::f32::consts::TAU;

use bevy::math::{Mat3, Vec2, Vec3};
use rayon::prelude::*;

use crate::{
    path_tracer::surface::{OFFSET, Reflected, Scattered},
    stage::{SceneCamera, Stage},
};

pub use crate::path_tracer::surface::{Gloss, Hit, LightSample, Ray, Surfaces};

mod surface;

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

/// Segments of a path before Russian roulette may end it.
const ROULETTE_DEPTH: u32 = 4;

/// The greatest probability with which Russian roulette lets a path go on.
const MAX_SURVIVAL: f32 = 0.95;

/// Traces paths through a scene.
struct Tracer<'a, S> {
    surfaces: &'a S,
    stage: &'a Stage,
    settings: TraceSettings,
    emissive_area: f32,
}

impl<'a, S: Surfaces> Tracer<'a, S> {
    fn new(surfaces: &'a S, stage: &'a Stage, settings: &TraceSettings) -> Self {
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
    fn direct(&self, hit: &Hit, to_viewer: Vec3) -> Vec3 {
        self.delta_lights(hit, to_viewer).total()
    }

    /// Radiance that a surface reflects of all else, by one path whose first direction is a point of the unit
    /// square.
    fn indirect(&self, hit: Hit, to_viewer: Vec3, first: Vec2, random: &mut Random) -> Reflected {
        let emitted = self.area_lights(&hit, to_viewer, random);
        let path = self.path(hit, to_viewer, first, random);
        Reflected {
            diffuse: emitted.diffuse + path.diffuse,
            specular: emitted.specular + path.specular,
        }
    }

    /// Radiance that a surface has from other surfaces and the sky, by one path, without next-event estimation at its
    /// first point.
    fn path(
        &self,
        mut hit: Hit,
        mut to_viewer: Vec3,
        first: Vec2,
        random: &mut Random,
    ) -> Reflected {
        let mut sum = Vec3::ZERO;
        let mut throughput = Vec3::ONE;
        let mut lobes = None;
        let mut first = Some(first);
        for depth in 2..=self.settings.depth {
            let at = first.take().unwrap_or_else(|| random.point());
            let Some(scattered) = hit.scatter(to_viewer, at, random) else {
                break;
            };
            let Scattered { direction, pdf, .. } = scattered;
            // What is reflected first is all in the two lobes, so that they can be told apart.
            match lobes {
                None => lobes = Some(scattered.reflected),
                Some(_) => throughput *= scattered.reflected.total(),
            }
            let of_first = lobes.unwrap_or_default();
            match self.surfaces.closest(hit.ray(direction)) {
                None => {
                    sum += throughput * self.stage.sky(direction);
                    break;
                }
                Some(next) => hit = next,
            }
            to_viewer = -direction;
            if hit.emission != Vec3::ZERO {
                let light_pdf = self.light_pdf(&hit, direction);
                sum += throughput * hit.emission * pdf / (pdf + light_pdf);
            }
            if depth < self.settings.depth {
                let light = self.delta_lights(&hit, to_viewer).total()
                    + self.area_lights(&hit, to_viewer, random).total();
                sum += throughput * light;
            }
            let survival = (throughput * of_first.total() * hit.albedo_of_all(to_viewer))
                .max_element()
                .min(MAX_SURVIVAL);
            if survival <= 0.0 {
                break;
            }
            if depth >= ROULETTE_DEPTH {
                if random.unit() >= survival {
                    break;
                }
                throughput /= survival;
            }
        }
        let of_first = lobes.unwrap_or_default();
        Reflected {
            diffuse: of_first.diffuse * sum,
            specular: of_first.specular * sum,
        }
    }

    /// Radiance that a surface reflects of point and directional lights.
    fn delta_lights(&self, hit: &Hit, to_viewer: Vec3) -> Reflected {
        let mut sum = Reflected::default();
        for light in &self.stage.point_lights {
            let to_light = light.position - hit.position;
            let distance = to_light.length();
            let direction = to_light / distance;
            let cosine = hit.normal.dot(direction);
            if cosine > 0.0 && !self.surfaces.blocked(hit.ray(direction), distance) {
                let illuminance = light.intensity_cd * cosine / (distance * distance);
                sum.add(hit.brdf(to_viewer, direction), illuminance);
            }
        }
        for sun in &self.stage.directional_lights {
            let direction = -sun.direction.normalize();
            let cosine = hit.normal.dot(direction);
            if cosine > 0.0 && !self.surfaces.blocked(hit.ray(direction), f32::INFINITY) {
                sum.add(hit.brdf(to_viewer, direction), sun.illuminance_lux * cosine);
            }
        }
        sum
    }

    /// Next-event estimation of the emissive surfaces: radiance that a surface reflects of a sampled point of them,
    /// weighted by multiple importance sampling.
    fn area_lights(&self, hit: &Hit, to_viewer: Vec3, random: &mut Random) -> Reflected {
        let mut sum = Reflected::default();
        if self.emissive_area <= 0.0 || hit.albedo == Vec3::ZERO && hit.gloss.is_none() {
            return sum;
        }
        let at = [random.unit(), random.unit(), random.unit()];
        let Some(light) = self.surfaces.sample_light(at) else {
            return sum;
        };
        let to_light = light.position - hit.position;
        let distance = to_light.length();
        let direction = to_light / distance;
        let (cosine, light_cosine) = (hit.normal.dot(direction), -light.normal.dot(direction));
        if cosine <= 0.0 || light_cosine <= 0.0 || distance <= 2.0 * OFFSET {
            return sum;
        }
        if self
            .surfaces
            .blocked(hit.ray(direction), distance - 2.0 * OFFSET)
        {
            return sum;
        }
        let light_pdf = distance * distance / (light_cosine * self.emissive_area);
        // The weight of the balance heuristic over the sample's density.
        let weighted = light.emission * cosine / (light_pdf + hit.pdf(to_viewer, direction));
        sum.add(hit.brdf(to_viewer, direction), weighted);
        sum
    }

    /// The density of directions, per steradian, with which next-event estimation samples a hit.
    fn light_pdf(&self, hit: &Hit, direction: Vec3) -> f32 {
        let light_cosine = -hit.face_normal.dot(direction);
        hit.distance * hit.distance / (light_cosine.max(1e-6) * self.emissive_area)
    }
}

/// Random numbers by PCG, the same for the same path of the same pixel.
pub struct Random(u32);

impl Random {
    /// Those of a path of a pixel.
    pub fn new(pixel: u32, sample: u32, seed: u32) -> Self {
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
    pub fn unit(&mut self) -> f32 {
        unit(self.bits())
    }

    /// A point of the unit square.
    pub fn point(&mut self) -> Vec2 {
        Vec2::new(self.unit(), self.unit())
    }
}

/// The R2 sequence of points of the unit square with a random start: those of a pixel or receiver.
struct R2Sequence([u32; 2]);

impl R2Sequence {
    fn new(index: u32, seed: u32) -> Self {
        let mut start = Random::new(index, u32::MAX, seed);
        Self([start.bits(), start.bits()])
    }

    fn point(&self, sample: u32) -> Vec2 {
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

/// A direction around a normal, with a density in proportion to its cosine, from a point of the unit square.
pub fn cosine_direction(normal: Vec3, at: Vec2) -> Vec3 {
    let (sin, cos) = (TAU * at.x).sin_cos();
    let radius = at.y.sqrt();
    let (tangent, bitangent) = normal.any_orthonormal_pair();
    radius * (cos * tangent + sin * bitangent) + (1.0 - at.y).max(0.0).sqrt() * normal
}

/// A point that receives light on one side.
#[derive(Clone, Copy, Debug)]
pub struct Receiver {
    /// The point, in metres.
    pub position: Vec3,
    /// The direction of the side, a unit vector.
    pub normal: Vec3,
}

/// The indirect light of a number of receivers, traced on all cores: irradiance over pi, which is the radiance that a
/// white surface reflects, of all light but that of point and directional lights without detours.
///
/// `receiver` gives the position of one of them for a point of the unit square, so that it may have an area; `None`
/// where it receives nothing there, and the mean is that of its other points. A receiver without any has no light.
pub fn trace_receivers(
    surfaces: &impl Surfaces,
    stage: &Stage,
    settings: &TraceSettings,
    count: u32,
    receiver: impl Fn(u32, Vec2) -> Option<Receiver> + Sync,
) -> Vec<Option<Vec3>> {
    let tracer = Tracer::new(surfaces, stage, settings);
    let settings = tracer.settings;
    let light = |index: u32| {
        let sequence = R2Sequence::new(index, settings.seed);
        let (mut sum, mut points) = (Vec3::ZERO, 0);
        for sample in 0..settings.samples {
            let mut random = Random::new(index, sample, settings.seed);
            let Some(Receiver { position, normal }) = receiver(index, random.point()) else {
                continue;
            };
            let hit = Hit {
                distance: 0.0,
                position,
                face_normal: normal,
                normal,
                albedo: Vec3::ONE,
                gloss: None,
                emission: Vec3::ZERO,
            };
            let light = tracer.indirect(hit, normal, sequence.point(sample), &mut random);
            sum += light.total();
            points += 1;
        }
        (points > 0).then(|| sum / points as f32)
    };
    (0..count).into_par_iter().map(light).collect()
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
    /// What of `indirect` their specular lobes reflect.
    pub specular: Vec<Vec3>,
}

/// The scene as its camera sees it, traced on all cores.
pub fn trace(surfaces: &impl Surfaces, stage: &Stage, settings: &TraceSettings) -> TracedPicture {
    let tracer = Tracer::new(surfaces, stage, settings);
    let view = View::new(&stage.camera);
    let (width, height) = (stage.camera.width, stage.camera.height);
    let pixels: Vec<Pixel> = (0..width * height)
        .into_par_iter()
        .map(|index| pixel(&tracer, &view, index))
        .collect();
    TracedPicture {
        width,
        total: pixels.iter().map(|p| p.total).collect(),
        direct: pixels.iter().map(|p| p.direct).collect(),
        indirect: pixels.iter().map(|p| p.indirect).collect(),
        specular: pixels.iter().map(|p| p.specular).collect(),
    }
}

#[derive(Clone, Copy, Default)]
struct Pixel {
    total: Vec3,
    direct: Vec3,
    indirect: Vec3,
    specular: Vec3,
}

fn pixel<S: Surfaces>(tracer: &Tracer<S>, view: &View, index: u32) -> Pixel {
    let (stage, settings) = (tracer.stage, &tracer.settings);
    let corner = Vec2::new(
        (index % stage.camera.width) as f32,
        (index / stage.camera.width) as f32,
    );
    let sequence = R2Sequence::new(index, settings.seed);
    let mut sum = Pixel::default();
    for sample in 0..settings.samples {
        let mut random = Random::new(index, sample, settings.seed);
        let at = corner + random.point();
        let ray = view.ray(at);
        let Some(hit) = tracer.surfaces.closest(ray) else {
            sum.total += stage.sky(ray.direction);
            continue;
        };
        let to_viewer = -ray.direction;
        let direct = tracer.direct(&hit, to_viewer);
        let indirect = tracer.indirect(hit, to_viewer, sequence.point(sample), &mut random);
        sum.direct += direct;
        sum.indirect += indirect.total();
        sum.specular += indirect.specular;
        sum.total += hit.emission + direct + indirect.total();
    }
    let scale = 1.0 / settings.samples as f32;
    Pixel {
        total: scale * sum.total,
        direct: scale * sum.direct,
        indirect: scale * sum.indirect,
        specular: scale * sum.specular,
    }
}

/// The rays of a camera.
#[derive(Clone, Copy, Debug)]
pub struct View {
    eye: Vec3,
    size: Vec2,
    /// The camera's right, up and forward, the first two half as long as the picture at distance 1.
    axes: Mat3,
}

impl View {
    pub fn new(camera: &SceneCamera) -> Self {
        let forward = (camera.target - camera.eye).normalize();
        let right = forward.cross(camera.up).normalize();
        let half_height = (0.5 * camera.fov_y_deg.to_radians()).tan();
        let half_width = half_height * camera.width as f32 / camera.height as f32;
        Self {
            eye: camera.eye,
            size: Vec2::new(camera.width as f32, camera.height as f32),
            axes: Mat3::from_cols(
                right * half_width,
                right.cross(forward) * half_height,
                forward,
            ),
        }
    }

    /// The ray through a point of the picture, in pixels from the top left.
    pub fn ray(&self, pixel: Vec2) -> Ray {
        let at = pixel / self.size;
        let at = Vec2::new(2.0 * at.x - 1.0, 1.0 - 2.0 * at.y);
        Ray {
            origin: self.eye,
            direction: (self.axes * at.extend(1.0)).normalize(),
        }
    }
}

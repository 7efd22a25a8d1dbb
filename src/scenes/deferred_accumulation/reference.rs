//! The same picture on the CPU.

use bevy::math::{Mat4, UVec2, Vec2, Vec3, Vec3Swizzles, Vec4Swizzles};
use bevy_ycocg_fb::{
    PackedFormat, Reconstruction,
    reference::{
        PackedImage, PackedPixel,
        pack::{pack, round_f16, stored},
    },
};

use crate::scenes::deferred_accumulation::{LightAccumulation, LightSource};

// Those of surface.wesl and light.wesl.
const BALL_CENTER: Vec3 = Vec3::new(0.0, 0.6, 0.0);
const BALL_RADIUS: f32 = 0.6;
const FLOOR_RADIUS: f32 = 4.0;
const SHININESS: f32 = 60.0;
const SPECULAR: f32 = 3.0;

/// Weights of the channels in luminance.
const LUMINANCE: Vec3 = Vec3::new(0.25, 0.5, 0.25);

#[derive(Clone, Copy, Debug)]
pub struct Eye {
    /// Its position in metres.
    pub position: Vec3,
    /// From normalised device coordinates to the world.
    pub world_from_clip: Mat4,
    /// Width and height of the picture in pixels.
    pub size: UVec2,
}

struct Surface {
    position: Vec3,
    normal: Vec3,
    to_eye: Vec3,
    albedo: Vec3,
}

#[derive(Clone, Copy, Default)]
struct Light {
    diffuse: Vec3,
    specular: Vec3,
}

/// The scene-linear picture, row after row from the top left.
pub fn render(eye: &Eye, sources: &[LightSource], way: LightAccumulation) -> Vec<[f32; 3]> {
    let pixels: Vec<UVec2> = (0..eye.size.y)
        .flat_map(|y| (0..eye.size.x).map(move |x| UVec2::new(x, y)))
        .collect();
    let surfaces: Vec<_> = pixels.iter().map(|pixel| surface_at(eye, *pixel)).collect();
    let lights = |i: usize| {
        let surface: &Option<Surface> = &surfaces[i];
        sources.iter().map(move |source| {
            surface
                .as_ref()
                .map_or(Light::default(), |s| light_of(s, source))
        })
    };
    let sums: Vec<Light> = match way {
        LightAccumulation::Exact => (0..pixels.len())
            .map(|i| Light {
                diffuse: half_sum(lights(i).map(|l| l.diffuse)),
                specular: half_sum(lights(i).map(|l| l.specular)),
            })
            .collect(),
        LightAccumulation::SpecularLuminance => (0..pixels.len())
            .map(|i| {
                let diffuse = half_sum(lights(i).map(|l| l.diffuse));
                let luminance = lights(i).map(|l| Vec3::splat(l.specular.dot(LUMINANCE)));
                Light {
                    diffuse,
                    specular: half_sum(luminance) * diffuse / diffuse.dot(LUMINANCE).max(1e-6),
                }
            })
            .collect(),
        LightAccumulation::Packed => {
            let unpacked = |part: fn(&Light) -> Vec3| {
                let pixels = pixels
                    .iter()
                    .enumerate()
                    .map(|(i, pixel)| packed_sum(*pixel, lights(i).map(|light| part(&light))));
                let image = PackedImage {
                    offset: [0, 0],
                    size: eye.size.into(),
                    format: PackedFormat::Float16,
                    pixels: pixels.collect(),
                };
                image.unpack(Reconstruction::Guided)
            };
            let (diffuse, specular) = (unpacked(|l| l.diffuse), unpacked(|l| l.specular));
            let light = |(diffuse, specular): ([f32; 3], [f32; 3])| Light {
                diffuse: diffuse.into(),
                specular: specular.into(),
            };
            diffuse.into_iter().zip(specular).map(light).collect()
        }
    };
    let color = |(surface, sum): (&Option<Surface>, Light)| match surface {
        Some(surface) => (surface.albedo * sum.diffuse + sum.specular).to_array(),
        None => [0.0; 3],
    };
    surfaces.iter().zip(sums).map(color).collect()
}

/// As a 16-bit target blends: rounded after each draw.
fn half_sum(values: impl Iterator<Item = Vec3>) -> Vec3 {
    values.fold(Vec3::ZERO, |sum, value| {
        Vec3::from_array((sum + value).to_array().map(round_f16))
    })
}

fn packed_sum(pixel: UVec2, values: impl Iterator<Item = Vec3>) -> PackedPixel {
    values.fold(PackedPixel::default(), |sum, value| {
        let packed = pack(value.to_array(), pixel.x, pixel.y);
        let sum = PackedPixel {
            luminance: sum.luminance + packed.luminance,
            chrominance: sum.chrominance + packed.chrominance,
        };
        stored(sum, PackedFormat::Float16)
    })
}

fn surface_at(eye: &Eye, pixel: UVec2) -> Option<Surface> {
    let in_viewport = (pixel.as_vec2() + 0.5) / eye.size.as_vec2();
    let ndc = Vec2::new(2.0, -2.0) * in_viewport + Vec2::new(-1.0, 1.0);
    let near = eye.world_from_clip * ndc.extend(1.0).extend(1.0);
    let ray = (near.xyz() / near.w - eye.position).normalize();

    let from_ball = eye.position - BALL_CENTER;
    let b = from_ball.dot(ray);
    let discriminant = b * b - from_ball.length_squared() + BALL_RADIUS * BALL_RADIUS;
    let to_ball = -b - discriminant.max(0.0).sqrt();
    if discriminant > 0.0 && to_ball > 0.0 {
        let position = eye.position + to_ball * ray;
        return Some(Surface {
            position,
            normal: (position - BALL_CENTER) / BALL_RADIUS,
            to_eye: -ray,
            albedo: Vec3::splat(0.8),
        });
    }
    let to_floor = -eye.position.y / ray.y;
    let position = eye.position + to_floor * ray;
    let is_floor = ray.y < 0.0 && to_floor > 0.0 && position.xz().length() < FLOOR_RADIUS;
    is_floor.then_some(Surface {
        position,
        normal: Vec3::Y,
        to_eye: -ray,
        albedo: Vec3::new(0.5, 0.48, 0.45),
    })
}

fn light_of(surface: &Surface, source: &LightSource) -> Light {
    let to_source = source.position - surface.position;
    let direction = to_source.normalize();
    let cosine = surface.normal.dot(direction).max(0.0);
    let halfway = (direction + surface.to_eye).normalize();
    let highlight = surface.normal.dot(halfway).max(0.0).powf(SHININESS);
    let received = source.intensity / to_source.length_squared();
    let specular = if cosine > 0.0 {
        SPECULAR * highlight
    } else {
        0.0
    };
    Light {
        diffuse: cosine * received,
        specular: specular * received,
    }
}

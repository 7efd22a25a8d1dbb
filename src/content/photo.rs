//! A stand-in for a photograph: a landscape with the statistics of one.

mod landscape;
mod objects;

use image::RgbImage;

use super::color::{Color, hex, mix, shade};
use super::lattice::{Noise, smoothstep};
use super::material::{Border, Sample, byte, render, units};
use landscape::{HAZE, HORIZON, Landscape, SHORE};

/// A landscape as a camera would take it: a smooth sky with clouds, hazy mountains, woods, a lake
/// with reflections, painted houses, a meadow in bloom, and balloons. It offers a codec what
/// photographs do: slow gradients, texture at many scales, sharp edges, saturated colours, and
/// sensor noise. 768x512 is the size of the Kodak images, which it can replace in examples.
pub fn photo_like(width: u32, height: u32, seed: u64) -> RgbImage {
    // Large enough never to be seen repeating.
    let noise = Noise::new(seed, [1 << 8; 2]);
    let scene = Scene {
        noise,
        aspect: width as f32 / height.max(1) as f32,
    };
    let unit = units(width, height).map(|units| units as f32);
    let mut photo = render(width, height, Border::Clamp, |[x, y]| Sample {
        color: scene.color([x / unit[0] * scene.aspect, y / unit[1]]),
        ..Sample::default()
    })
    .color;

    let sensor = noise.stream(1);
    for (x, y, pixel) in photo.enumerate_pixels_mut() {
        let noise = |stream| sensor.stream(stream).uniform(x as i32, y as i32) - 0.5;
        // The sum of two uniform deviates is bell-shaped enough; chroma is noisy, too, but less.
        let luma = noise(0) + noise(1);
        for (channel, value) in pixel.0.iter_mut().enumerate() {
            let grain = luma + 0.5 * noise(2 + channel as u32);
            *value = byte(f32::from(*value) / 255.0 + 0.012 * grain);
        }
    }
    photo
}

/// The scene, seen at points of which y runs from 0 (top) to 1 and x from 0 to `aspect`.
struct Scene {
    noise: Noise,
    aspect: f32,
}

impl Scene {
    fn color(&self, point: [f32; 2]) -> Color {
        let color = if point[1] > SHORE {
            landscape::meadow(self.noise, point)
        } else if point[1] > HORIZON {
            self.lake(point)
        } else {
            self.above_horizon(point)
        };
        let color = objects::houses(self.noise.stream(5), point, SHORE).unwrap_or(color);
        let corner = (point[0] / self.aspect - 0.5).hypot(point[1] - 0.5);
        shade(color, 1.04 - 0.3 * corner * corner)
    }

    fn above_horizon(&self, point: [f32; 2]) -> Color {
        objects::balloons(self.noise.stream(4), point, self.aspect)
            .or_else(|| {
                Landscape {
                    noise: self.noise.stream(3),
                }
                .ridges(point)
            })
            .unwrap_or_else(|| self.sky(point))
    }

    fn sky(&self, [x, y]: [f32; 2]) -> Color {
        let noise = self.noise.stream(2);
        let clear = mix(hex(0x2F6DB5), HAZE, smoothstep(-0.1, HORIZON, y));
        // Clouds flatten towards the horizon.
        let distance = 0.25 / (HORIZON + 0.08 - y);
        let cloud_point = [x * distance + 3.0, 2.2 * distance];
        let density = noise.fractal(cloud_point, [2, 3], 6) + 0.12;
        let lit = noise.fractal([cloud_point[0] - 0.05, cloud_point[1] - 0.06], [2, 3], 6) + 0.12;
        let cloud = mix(hex(0xFBF7EF), hex(0x98A2B3), smoothstep(-0.2, 0.35, lit));
        mix(clear, cloud, 0.92 * smoothstep(0.0, 0.32, density))
    }

    /// The scene above, mirrored in ripples that look finer the farther they are.
    fn lake(&self, [x, y]: [f32; 2]) -> Color {
        let noise = self.noise.stream(6);
        let near = (y - HORIZON) / (SHORE - HORIZON);
        let distance = 0.1 / (y - HORIZON + 0.02);
        let ripple = noise.fractal([x * distance * 2.0, distance * 6.0], [5, 12], 4);
        let mirrored = [
            x + 0.010 * ripple * near,
            HORIZON - 1.15 * (y - HORIZON) + 0.035 * ripple * near,
        ];
        let reflection = self.above_horizon([mirrored[0], mirrored[1].min(HORIZON)]);
        let water = mix(hex(0x1D4A5A), hex(0x2F6672), near);
        let color = mix(reflection, water, 0.25 + 0.3 * near);
        let glint = smoothstep(0.45, 0.8, ripple) * 0.45;
        mix(shade(color, 0.95 + 0.15 * ripple), hex(0xEAF3F5), glint)
    }
}

//! What is filtered, without a rasteriser: a surface and a texture on it; and pictures of it in linear colours, true ones
//! and computed ones, and as a display shows them.

use bevy_ewa::{
    EwaKernel, EwaSettings,
    mips::texel::{linear_from_srgb, srgb_from_linear},
    reference::{
        Derivatives, Texture, sample,
        scenes::{Surface, ground_truth},
    },
};
use image::RgbImage;
use rayon::prelude::*;

use crate::content;

#[derive(Clone, Copy)]
pub struct EwaScene {
    /// Its name in the report.
    pub name: &'static str,
    /// Where the texture is.
    pub surface: fn() -> Surface,
    pub texture: fn() -> Texture,
}

pub const SCENES: [EwaScene; 7] = [
    EwaScene {
        name: "tunnel",
        surface: || Surface::Tunnel {
            tan_half_fov: 1.0,
            around: 4.0,
            along: 0.5,
            camera_position: 0.0,
        },
        texture: checker,
    },
    EwaScene {
        name: "checker_1deg",
        surface: || plane(1.0, 0.5, 0.0, 0.5),
        texture: checker,
    },
    EwaScene {
        name: "checker_5deg",
        surface: || plane(5.0, 3.0, 0.0, 1.0),
        texture: checker,
    },
    EwaScene {
        name: "checker_5deg_45",
        surface: || plane(5.0, 3.0, 45.0, 1.0),
        texture: checker,
    },
    EwaScene {
        name: "text",
        surface: || plane(8.0, 5.0, 15.0, 0.4),
        texture: || from_image(&content::text(512, 512, 3).color),
    },
    EwaScene {
        name: "srgb_stripes",
        surface: || plane(5.0, 3.0, 30.0, 0.5),
        texture: || {
            Texture::from_fn([256, 256], |x, _| {
                let v = f64::from(u8::from(x / 2 % 2 == 0));
                [v, v, v, 1.0]
            })
        },
    },
    EwaScene {
        name: "floor",
        surface: || plane(15.0, 12.0, 20.0, 0.5),
        texture: || from_image(&content::bricks(512, 512, 5).color),
    },
];

fn plane(grazing: f64, half_fov: f64, rotation: f64, scale: f64) -> Surface {
    Surface::Plane {
        grazing_angle: grazing.to_radians(),
        tan_half_fov: half_fov.to_radians().tan(),
        rotation: rotation.to_radians(),
        scale,
        camera_position: 0.0,
    }
}

/// Checks of 32 texels, nearly black and nearly white.
fn checker() -> Texture {
    Texture::from_fn([256, 256], |x, y| {
        let v = if (x / 32 + y / 32) % 2 == 0 {
            0.9
        } else {
            0.02
        };
        [v, v, v, 1.0]
    })
}

fn from_image(image: &RgbImage) -> Texture {
    Texture::from_fn(image.dimensions().into(), |x, y| {
        let [r, g, b] = image[(x, y)].0.map(|byte| {
            let value = f32::from(byte) / 255.0;
            f64::from(linear_from_srgb(value))
        });
        [r, g, b, 1.0]
    })
}

impl EwaScene {
    /// Coordinates and derivatives of all pixels of a square picture, as precise as a shader has
    /// them.
    pub fn coordinates(&self, size: u32) -> Vec<([f64; 2], Derivatives)> {
        coordinates(&(self.surface)(), size)
    }
}

/// As [`EwaScene::coordinates`], of a surface.
pub fn coordinates(surface: &Surface, size: u32) -> Vec<([f64; 2], Derivatives)> {
    let rounded = |c: [f64; 2]| c.map(|c| f64::from(c as f32));
    (0..size * size)
        .map(|i| {
            let (uv, d) = surface.pixel(size, [i % size, i / size]);
            let (dx, dy) = (rounded(d.dx), rounded(d.dy));
            (rounded(uv), Derivatives { dx, dy })
        })
        .collect()
}

/// Linear colours of a square picture, row after row.
pub type Pixels = Vec<[f64; 3]>;

/// What a picture should look like, by `rate` times `rate` points a pixel.
pub fn true_picture(texture: &Texture, surface: &Surface, size: u32, rate: u32) -> Pixels {
    rows(size, |y| {
        let texture = texture.clone();
        let pixel =
            move |x| ground_truth(&texture, surface, size, [x, y], EwaKernel::default(), rate);
        (0..size).map(pixel).map(rgb).collect()
    })
}

/// The picture by the reference in plain Rust, and its fetches a pixel.
pub fn computed_picture(
    texture: &Texture,
    coordinates: &[([f64; 2], Derivatives)],
    size: u32,
    settings: &EwaSettings,
    frame: u32,
) -> (Pixels, f64) {
    let sampled = rows(size, |y| {
        let texture = texture.clone();
        let row = &coordinates[(y * size) as usize..][..size as usize];
        row.iter()
            .map(|(uv, d)| sample(&texture, *uv, *d, settings, frame))
            .collect()
    });
    let fetches: u64 = sampled.iter().map(|s| u64::from(s.fetches)).sum();
    let pixels = sampled.iter().map(|s| rgb(s.color)).collect();
    (pixels, fetches as f64 / f64::from(size * size))
}

fn rows<T: Send>(size: u32, row: impl Fn(u32) -> Vec<T> + Sync + Send) -> Vec<T> {
    (0..size).into_par_iter().flat_map_iter(row).collect()
}

fn rgb([r, g, b, _]: [f64; 4]) -> [f64; 3] {
    [r, g, b]
}

/// The mean of pictures of the same size.
pub fn mean(pictures: &[Pixels]) -> Pixels {
    let Some(first) = pictures.first() else {
        return Pixels::new();
    };
    let count = pictures.len() as f64;
    (0..first.len())
        .map(|i| [0, 1, 2].map(|c| pictures.iter().map(|p| p[i][c]).sum::<f64>() / count))
        .collect()
}

pub fn display(pixels: &Pixels, size: u32) -> RgbImage {
    RgbImage::from_fn(size, size, |x, y| {
        image::Rgb(pixels[(y * size + x) as usize].map(|c| {
            let value = srgb_from_linear((c as f32).clamp(0.0, 1.0));
            (value * 255.0).round() as u8
        }))
    })
}

/// Mean squared error of linear values, in squares of 8-bit units; finer than that of bytes.
pub fn linear_mse(a: &Pixels, b: &Pixels) -> f64 {
    let pairs = a.iter().flatten().zip(b.iter().flatten());
    let sum: f64 = pairs.map(|(a, b)| ((a - b) * 255.0).powi(2)).sum();
    sum / (3 * a.len().max(1)) as f64
}

//! What is filtered, without a rasteriser: a surface and a texture on it.

use bevy_ewa::{
    mips::texel::linear_from_srgb,
    reference::{Derivatives, Texture, scenes::Surface},
};
use image::RgbImage;

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

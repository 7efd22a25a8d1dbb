//! The picture of a material's maps under lights, by which encoded maps are compared.

use bevy_wavelet_tex::codec::{
    angle::{unit, unit_of},
    color::{linear_from_srgb, srgb_from_linear},
    quality::psnr_of,
};
use glam::DVec3;
use rayon::prelude::*;

use crate::{
    picture::Picture,
    shading::{Surface, radiance},
};

/// A material of a glTF file: the texture of each map, and the factors that its values are multiplied by.
pub struct Material {
    pub name: String,
    pub base_color: Option<usize>,
    pub emissive: Option<usize>,
    pub normal: Option<usize>,
    pub metallic_roughness: Option<usize>,
    pub occlusion: Option<usize>,
    pub factors: Factors,
}

#[derive(Clone, Copy)]
pub struct Factors {
    pub base_color: DVec3,
    pub emissive: DVec3,
    pub metallic: f64,
    pub roughness: f64,
    pub normal_scale: f64,
    pub occlusion_strength: f64,
}

impl Material {
    /// The textures of its maps.
    pub fn textures(&self) -> impl Iterator<Item = usize> {
        self.maps().into_iter().flatten()
    }

    fn maps(&self) -> [Option<usize>; 5] {
        [
            self.base_color,
            self.emissive,
            self.normal,
            self.metallic_roughness,
            self.occlusion,
        ]
    }

    /// Renders the material at `size` pixels, in sRGB of 8 bits. `texture` returns the pixels of a texture.
    ///
    /// Radiance is compressed by `c / (1 + c)`, so that highlights count.
    pub fn render<'a>(
        &self,
        size: [u32; 2],
        texture: impl Fn(usize) -> &'a Picture + Sync,
    ) -> Vec<[u8; 3]> {
        let [width, height] = size;
        let maps = self.maps().map(|map| map.map(&texture));
        let pixel = |i: u32| {
            let uv = [
                (f64::from(i % width) + 0.5) / f64::from(width),
                (f64::from(i / width) + 0.5) / f64::from(height),
            ];
            let position = [2.0 * uv[0] - 1.0, 1.0 - 2.0 * uv[1]];
            let color = radiance(&self.surface(maps, uv), position);
            (color / (1.0 + color)).to_array().map(srgb_byte)
        };
        (0..width * height).into_par_iter().map(pixel).collect()
    }

    fn surface(&self, maps: [Option<&Picture>; 5], uv: [f64; 2]) -> Surface {
        let [base_color, emissive, normal, metallic_roughness, occlusion] =
            maps.map(|map| map.map(|picture| nearest(picture, uv)));
        let factors = &self.factors;
        let color = |texel: Option<[u8; 4]>, factor: DVec3| {
            let texel = texel.unwrap_or([255; 4]);
            let linear = |c: usize| f64::from(linear_from_srgb(f32::from(texel[c]) / 255.0));
            DVec3::from([0, 1, 2].map(linear)) * factor
        };
        let channel = |texel: Option<[u8; 4]>, c: usize| {
            texel.map_or(1.0, |texel| f64::from(texel[c]) / 255.0)
        };
        Surface {
            base_color: color(base_color, factors.base_color),
            emissive: color(emissive, factors.emissive),
            normal: normal.map_or(DVec3::Z, |texel| {
                let [x, y, z] = unit_of(texel);
                let [x, y] = [x, y].map(|v| v * factors.normal_scale);
                unit([x, y, z]).into()
            }),
            metallic: channel(metallic_roughness, 2) * factors.metallic,
            roughness: channel(metallic_roughness, 1) * factors.roughness,
            occlusion: 1.0 + factors.occlusion_strength * (channel(occlusion, 0) - 1.0),
        }
    }
}

/// PSNR between two renderings in dB.
pub fn psnr(a: &[[u8; 3]], b: &[[u8; 3]]) -> f64 {
    let (a, b) = (a.as_flattened(), b.as_flattened());
    let error = |(a, b): (&u8, &u8)| f64::from(a.abs_diff(*b)).powi(2);
    psnr_of(a.iter().zip(b).map(error).sum::<f64>() / a.len() as f64)
}

fn nearest(picture: &Picture, uv: [f64; 2]) -> [u8; 4] {
    let at = |axis: usize| {
        let size = picture.size[axis];
        ((uv[axis] * f64::from(size)) as u32).min(size - 1)
    };
    picture.pixels[(at(1) * picture.size[0] + at(0)) as usize]
}

fn srgb_byte(linear: f64) -> u8 {
    (srgb_from_linear(linear.clamp(0.0, 1.0) as f32) * 255.0).round() as u8
}

//! The picture of a material's maps under lights, by which encoded maps are compared.

use bevy::math::DVec3;
use bevy_wavelet_tex::codec::{
    angle::{unit, unit_of},
    color::{linear_from_srgb, srgb_from_linear},
};
use image::RgbImage;
use rayon::prelude::*;

use super::shading::{Surface, radiance};

/// A material of a glTF file, with the factors that the values of its maps are multiplied by.
pub(super) struct Material {
    pub(super) name: String,
    /// Indices of the images of base colour, emission, normals, metallic-roughness and occlusion.
    pub(super) maps: [Option<usize>; 5],
    base_color: DVec3,
    emissive: DVec3,
    metallic: f64,
    roughness: f64,
    normal_scale: f64,
    occlusion_strength: f64,
}

impl Material {
    pub(super) fn new(material: &gltf::Material) -> Self {
        let pbr = material.pbr_metallic_roughness();
        let (normal, occlusion) = (material.normal_texture(), material.occlusion_texture());
        let [r, g, b, _] = pbr.base_color_factor();
        let color = |color: [f32; 3]| DVec3::from(color.map(f64::from));
        let textures = [
            pbr.base_color_texture().map(|map| map.texture()),
            material.emissive_texture().map(|map| map.texture()),
            normal.as_ref().map(|map| map.texture()),
            pbr.metallic_roughness_texture().map(|map| map.texture()),
            occlusion.as_ref().map(|map| map.texture()),
        ];
        Self {
            name: material.name().unwrap_or_default().into(),
            maps: textures.map(|texture| Some(texture?.source().index())),
            base_color: color([r, g, b]),
            emissive: color(material.emissive_factor()),
            metallic: pbr.metallic_factor().into(),
            roughness: pbr.roughness_factor().into(),
            normal_scale: normal.map_or(1.0, |map| map.scale().into()),
            occlusion_strength: occlusion.map_or(1.0, |map| map.strength().into()),
        }
    }

    /// Renders the material at `size` pixels, in sRGB. `picture` returns that of an image.
    ///
    /// Radiance is compressed by `c / (1 + c)`, so that highlights count.
    pub(super) fn render<'a>(
        &self,
        size: [u32; 2],
        picture: impl Fn(usize) -> &'a RgbImage,
    ) -> RgbImage {
        let maps = self.maps.map(|image| image.map(&picture));
        let [width, height] = size;
        let pixel = |i: u32| {
            let at = |i: u32, size: u32| (f64::from(i) + 0.5) / f64::from(size);
            let uv = [at(i % width, width), at(i / width, height)];
            let position = [2.0 * uv[0] - 1.0, 1.0 - 2.0 * uv[1]];
            let color = radiance(&self.surface(maps, uv), position);
            (color / (1.0 + color)).to_array().map(srgb_byte)
        };
        let pixels: Vec<_> = (0..width * height).into_par_iter().map(pixel).collect();
        RgbImage::from_raw(width, height, pixels.into_flattened()).expect("as many pixels")
    }

    fn surface(&self, maps: [Option<&RgbImage>; 5], uv: [f64; 2]) -> Surface {
        let texels = maps.map(|map| map.map(|picture| nearest(picture, uv)));
        let [base_color, emissive, normal, metallic_roughness, occlusion] = texels;
        let color = |texel: Option<[u8; 3]>, factor: DVec3| {
            let linear = |v: u8| f64::from(linear_from_srgb(f32::from(v) / 255.0));
            DVec3::from(texel.unwrap_or([255; 3]).map(linear)) * factor
        };
        let channel = |texel: Option<[u8; 3]>, c: usize| {
            texel.map_or(1.0, |texel| f64::from(texel[c]) / 255.0)
        };
        Surface {
            base_color: color(base_color, self.base_color),
            emissive: color(emissive, self.emissive),
            normal: normal.map_or(DVec3::Z, |[x, y, z]| {
                let [x, y, z] = unit_of([x, y, z, 255]);
                let [x, y] = [x, y].map(|v| v * self.normal_scale);
                unit([x, y, z]).into()
            }),
            metallic: channel(metallic_roughness, 2) * self.metallic,
            roughness: channel(metallic_roughness, 1) * self.roughness,
            occlusion: 1.0 + self.occlusion_strength * (channel(occlusion, 0) - 1.0),
        }
    }
}

fn nearest(picture: &RgbImage, uv: [f64; 2]) -> [u8; 3] {
    let at = |uv: f64, size: u32| ((uv * f64::from(size)) as u32).min(size - 1);
    let [x, y] = [at(uv[0], picture.width()), at(uv[1], picture.height())];
    picture.get_pixel(x, y).0
}

fn srgb_byte(linear: f64) -> u8 {
    (srgb_from_linear(linear.clamp(0.0, 1.0) as f32) * 255.0).round() as u8
}

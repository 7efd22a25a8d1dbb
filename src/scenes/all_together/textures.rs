//! The textures of the hall, as they are and encoded.

use std::collections::{HashMap, hash_map::Entry};

use bevy::prelude::*;
use bevy_voxel_gi::MeshVoxelMaterial;
use bevy_wavelet_tex::codec::{
    encoder::encode_rgb8,
    image::{ColorSpace, Content, WaveletImage},
    rate::Rate,
    settings::{EncodeSettings, Formats},
};
use image::{DynamicImage, Rgb, RgbImage, RgbaImage};

use super::hall::Matter;
use crate::content;

/// Side of the generated materials in pixels.
const SIZE: u32 = 512;
const SEED: u64 = 3;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Role {
    Color,
    Normal,
    /// Where it is.
    Mask,
}

#[derive(Resource)]
pub struct Textures {
    maps: HashMap<(Matter, Role), RgbaImage>,
    /// Colours with the mask as their alpha, as a `StandardMaterial` wants them.
    masked: HashMap<Matter, RgbaImage>,
    encoded: HashMap<(Matter, Role, Rate), WaveletImage>,
}

impl Default for Textures {
    fn default() -> Self {
        let mut maps = HashMap::new();
        let mut masked = HashMap::new();
        for (matter, generate) in [
            (
                Matter::Bricks,
                content::bricks as fn(u32, u32, u64) -> content::Material,
            ),
            (Matter::Planks, content::wood),
            (Matter::Stone, content::noise),
            (Matter::Leaves, content::foliage),
        ] {
            let material = generate(SIZE, SIZE, SEED);
            let color = rgba(material.color);
            if matter == Matter::Leaves {
                let mut both = color.clone();
                for (pixel, mask) in both.pixels_mut().zip(material.mask.pixels()) {
                    pixel.0[3] = mask.0[0];
                }
                masked.insert(matter, both);
                let mask = DynamicImage::from(material.mask).into_rgba8();
                maps.insert((matter, Role::Mask), mask);
            }
            maps.insert((matter, Role::Color), color);
            maps.insert((matter, Role::Normal), rgba(material.normal));
        }
        let picture = content::photo_like(768, 512, SEED);
        maps.insert((Matter::Picture, Role::Color), rgba(picture));
        maps.insert((Matter::Tiles, Role::Color), rgba(tiles()));
        Self {
            maps,
            masked,
            encoded: HashMap::new(),
        }
    }
}

impl Textures {
    /// A texture with mips as Bevy has it; none where a matter has no such texture.
    pub fn uncompressed(&self, matter: Matter, role: Role) -> Option<Image> {
        let pixels = match role {
            Role::Color => self.masked.get(&matter),
            Role::Normal | Role::Mask => None,
        };
        let pixels = pixels.or_else(|| self.maps.get(&(matter, role)))?;
        Some(content::mipped_texture(pixels, role == Role::Color))
    }

    /// Mean of the colours that a mask leaves, linear, and how much it leaves.
    pub fn surface(&self, matter: Matter) -> MeshVoxelMaterial {
        let Some(colors) = self.maps.get(&(matter, Role::Color)) else {
            return MeshVoxelMaterial::default();
        };
        let mask = self.maps.get(&(matter, Role::Mask));
        let is_there = |x, y| mask.is_none_or(|mask| mask.get_pixel(x, y)[0] >= 128);
        let mut sum = Vec3::ZERO;
        let mut count = 0.0;
        for (_, _, pixel) in colors
            .enumerate_pixels()
            .filter(|(x, y, _)| is_there(*x, *y))
        {
            sum += LinearRgba::from(Srgba::rgb_u8(pixel[0], pixel[1], pixel[2])).to_vec3();
            count += 1.0;
        }
        MeshVoxelMaterial {
            albedo: (count > 0.0).then(|| sum / count),
            coverage: Some(count / colors.pixels().len() as f32),
            ..default()
        }
    }

    /// The same encoded, colours at this rate.
    pub fn encoded(&mut self, matter: Matter, role: Role, color: Rate) -> Option<&WaveletImage> {
        let pixels = self.maps.get(&(matter, role))?;
        let (rate, color_space) = match role {
            Role::Color => (color, ColorSpace::Srgb),
            Role::Normal => (Rate::usual(Content::Normal), ColorSpace::Linear),
            Role::Mask => (Rate::usual(Content::Gray), ColorSpace::Linear),
        };
        match self.encoded.entry((matter, role, rate)) {
            Entry::Occupied(known) => Some(known.into_mut()),
            Entry::Vacant(vacant) => {
                let settings = EncodeSettings {
                    rate,
                    color_space,
                    formats: Formats::Wavelet,
                    ..EncodeSettings::default()
                };
                let rgb: Vec<_> = pixels.pixels().map(|p| [p[0], p[1], p[2]]).collect();
                match encode_rgb8(&rgb, pixels.dimensions().into(), &settings) {
                    Ok(image) => Some(vacant.insert(image)),
                    Err(error) => {
                        error!("{error}");
                        None
                    }
                }
            }
        }
    }
}

fn rgba(image: RgbImage) -> RgbaImage {
    DynamicImage::from(image).into_rgba8()
}

/// Tiles of two kinds of polished stone, with joints.
fn tiles() -> RgbImage {
    const TILE: u32 = SIZE / 8;
    const JOINT: u32 = 2;
    let grain = content::noise(SIZE, SIZE, SEED + 1).color;
    RgbImage::from_fn(SIZE, SIZE, |x, y| {
        let in_joint = x % TILE < JOINT || y % TILE < JOINT;
        let light = (x / TILE + y / TILE).is_multiple_of(2);
        let tint = match (in_joint, light) {
            (true, _) => [40.0, 37.0, 34.0],
            (false, true) => [226.0, 216.0, 196.0],
            (false, false) => [84.0, 52.0, 44.0],
        };
        let Rgb(grain) = grain.get_pixel(x, y);
        let shade = 0.82 + 0.3 * f32::from(grain[1]) / 255.0;
        Rgb(tint.map(|level: f32| (level * shade).clamp(0.0, 255.0) as u8))
    })
}

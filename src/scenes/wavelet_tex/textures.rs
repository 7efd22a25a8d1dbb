//! The textures of the room, as they are and encoded.

use std::path::Path;

use bevy::{
    image::{ImageAddressMode, ImageSampler},
    prelude::*,
};
use bevy_wavelet_tex::codec::{
    color::ycocg_from_rgb,
    image::{ColorSpace, Content, WaveletImage},
    rate::Rate,
    settings::{Effort, EncodeSettings},
    source::{Pixels, Source},
};
use image::{DynamicImage, Rgba, RgbaImage};

use crate::{
    content,
    scenes::wavelet_tex::room::Surface,
    wavelets::{encoded, wavelets},
};

/// Side of the generated materials in pixels.
const MATERIAL_SIZE: u32 = 512;

#[derive(Resource)]
pub struct Sources {
    picture: SourceMap,
    bricks: [SourceMap; 2],
    floor: [SourceMap; 2],
    plant: [SourceMap; 3],
    plant_with_mask: SourceMap,
    encoded_with: Option<(Effort, Rate)>,
}

/// One map, and what the codec made of it.
pub struct SourceMap {
    pixels: RgbaImage,
    content: Content,
    color_space: ColorSpace,
    encoded: Option<WaveletImage>,
}

impl Sources {
    /// The room with the user's picture in it, or a generated one.
    pub fn new(picture: Option<&Path>) -> Self {
        let opened = picture.and_then(|path| match image::open(path) {
            Ok(image) => Some(image),
            Err(error) => {
                eprintln!(
                    "cannot show '{}': {error}; a generated picture stands in",
                    path.display()
                );
                None
            }
        });
        let picture = opened.unwrap_or_else(|| content::photo_like(768, 512, 1).into());
        let color = |image: DynamicImage| SourceMap::new(image, Content::Color, ColorSpace::Srgb);
        let normal =
            |image: DynamicImage| SourceMap::new(image, Content::Normal, ColorSpace::Linear);
        let [bricks, wood, leaves] = [content::bricks, content::wood, content::foliage]
            .map(|generate| generate(MATERIAL_SIZE, MATERIAL_SIZE, 1));
        let masked = leaves.masked_color();
        Self {
            picture: color(picture),
            bricks: [color(bricks.color.into()), normal(bricks.normal.into())],
            floor: [color(wood.color.into()), normal(wood.normal.into())],
            plant: [
                color(leaves.color.into()),
                normal(leaves.normal.into()),
                SourceMap::new(leaves.mask.into(), Content::Gray, ColorSpace::Linear),
            ],
            plant_with_mask: color(masked.into()),
            encoded_with: None,
        }
    }

    pub fn picture(&self) -> &RgbaImage {
        &self.picture.pixels
    }

    /// The same for the encoder.
    pub fn picture_source(&self) -> Source<'_> {
        let pixels: &[[u8; 4]] = bytemuck::cast_slice(self.picture.pixels.as_raw());
        Source::new(
            self.picture.pixels.dimensions().into(),
            Pixels::Rgba8(pixels),
        )
    }

    /// Encodes all maps, unless they are; `color` is the rate of colours.
    pub fn encode(&mut self, effort: Effort, color: Rate) {
        if self.encoded_with == Some((effort, color)) {
            return;
        }
        let maps = [&mut self.picture].into_iter();
        let maps = maps
            .chain(&mut self.bricks)
            .chain(&mut self.floor)
            .chain(&mut self.plant);
        maps.for_each(|map| map.encode(effort, color));
        self.encoded_with = Some((effort, color));
    }

    pub fn base_color(&self, surface: Surface) -> &SourceMap {
        match surface {
            Surface::Picture => &self.picture,
            Surface::Bricks => &self.bricks[0],
            Surface::Floor => &self.floor[0],
            Surface::Plant => &self.plant[0],
        }
    }

    /// The same with the mask as its alpha, as a `StandardMaterial` wants it.
    pub fn base_color_with_mask(&self, surface: Surface) -> &SourceMap {
        match surface {
            Surface::Plant => &self.plant_with_mask,
            _ => self.base_color(surface),
        }
    }

    pub fn normal(&self, surface: Surface) -> Option<&SourceMap> {
        match surface {
            Surface::Picture => None,
            Surface::Bricks => Some(&self.bricks[1]),
            Surface::Floor => Some(&self.floor[1]),
            Surface::Plant => Some(&self.plant[1]),
        }
    }

    pub fn mask(&self, surface: Surface) -> Option<&SourceMap> {
        (surface == Surface::Plant).then(|| &self.plant[2])
    }
}

impl SourceMap {
    fn new(image: DynamicImage, content: Content, color_space: ColorSpace) -> Self {
        Self {
            pixels: image.into_rgba8(),
            content,
            color_space,
            encoded: None,
        }
    }

    fn encode(&mut self, effort: Effort, color: Rate) {
        let rate = match self.content {
            Content::Color => color,
            other => Rate::usual(other),
        };
        let settings = EncodeSettings {
            effort,
            ..wavelets(rate, self.color_space)
        };
        match encoded(&self.pixels, &settings) {
            Ok(image) => self.encoded = Some(image),
            // A picture of the user's can be too large; what was shown stays.
            Err(error) => eprintln!("{error}"),
        }
    }

    /// What the codec made of it.
    ///
    /// # Panics
    /// Before [`Sources::encode`].
    pub fn encoded(&self) -> &WaveletImage {
        self.encoded.as_ref().expect("encoded at start")
    }

    /// The original as RGBA8 with a full chain of mips, filtered in linear light.
    pub fn uncompressed(&self, repeats: bool) -> Image {
        let mut image = content::mipped_texture(&self.pixels, self.color_space == ColorSpace::Srgb);
        if let ImageSampler::Descriptor(sampler) = &mut image.sampler
            && !repeats
        {
            sampler.set_address_mode(ImageAddressMode::ClampToEdge);
        }
        image
    }
}

/// The luma of a picture, in all three channels.
pub fn gray(picture: &RgbaImage) -> RgbaImage {
    let mut gray = picture.clone();
    for Rgba([r, g, b, _]) in gray.pixels_mut() {
        let luma = ycocg_from_rgb([*r, *g, *b].map(f32::from)).y.round() as u8;
        [*r, *g, *b] = [luma; 3];
    }
    gray
}

//! Pixels from image files and from wavelet textures.

use std::{io::Cursor, path::Path};

use bevy_wavelet_tex::{
    codec::{
        angle::normal_blue,
        decoder::decode,
        image::{ColorSpace, Content, WaveletImage},
        reduce::reduced_rgba8,
        source::Pixels,
    },
    file,
};
use image::{ColorType, DynamicImage, GrayImage, ImageFormat, RgbImage, RgbaImage};

use crate::{decoded::Decoded, error::Error, files, image_file};

/// The pixels of an image file or of a texture.
pub struct Picture {
    pub size: [u32; 2],
    /// RGBA of 8 bits, row by row from the top; gray is repeated in three channels.
    pub pixels: Vec<[u8; 4]>,
    /// RGBA of 16 bits, where the image has 16 bits a channel.
    words: Option<Vec<[u16; 4]>>,
    /// Whether the picture has an alpha channel.
    pub has_alpha: bool,
    pub content: Content,
    /// The color space that the image file states.
    pub color_space: Option<ColorSpace>,
    /// Whether the image file has red and green alone.
    is_red_green: bool,
}

impl Picture {
    /// Reads an image file. Its content is gray or colour, since none of them marks a normal map.
    pub fn read(path: &Path) -> Result<Self, Error> {
        Self::from_bytes(path, &files::read(path)?)
    }

    /// Reads an image file or the largest level of a texture, which differ in their first bytes.
    pub fn read_any(path: &Path) -> Result<Self, Error> {
        let bytes = files::read(path)?;
        match file::read(&bytes) {
            Ok(texture) => Ok(Self::from_texture(&texture, 0)),
            Err(file::ReadError::Magic) => Self::from_bytes(path, &bytes),
            Err(error) => Err(Error::file(path, error)),
        }
    }

    pub fn from_bytes(path: &Path, bytes: &[u8]) -> Result<Self, Error> {
        let Decoded {
            image,
            color_space,
            is_red_green,
        } = image_file::decode(path, bytes)?;
        let color = image.color();
        let content = if color.has_color() {
            Content::Color
        } else {
            Content::Gray
        };
        let words = matches!(
            color,
            ColorType::L16 | ColorType::La16 | ColorType::Rgb16 | ColorType::Rgba16
        )
        .then(|| image.to_rgba16().pixels().map(|p| p.0).collect());
        Ok(Self {
            size: [image.width(), image.height()],
            pixels: image.into_rgba8().pixels().map(|p| p.0).collect(),
            words,
            has_alpha: color.has_alpha(),
            content,
            color_space,
            is_red_green,
        })
    }

    /// Decodes one mip level of a texture.
    pub fn from_texture(texture: &WaveletImage, level: u32) -> Self {
        let decoded = decode(texture, level);
        Self {
            size: decoded.size,
            pixels: decoded.to_rgba8(texture.content),
            words: None,
            has_alpha: decoded.alpha.is_some(),
            content: texture.content,
            color_space: None,
            is_red_green: false,
        }
    }

    /// The pixels as the input of the encoder, with all their bits.
    pub fn source(&self) -> Pixels<'_> {
        match &self.words {
            Some(words) => Pixels::Rgba16(words),
            None => Pixels::Rgba8(&self.pixels),
        }
    }

    /// Halves the picture until no side is longer than `most`, in linear light where it is sRGB.
    pub fn reduced(&self, most: u32, color_space: ColorSpace) -> Self {
        let source = self.source();
        let (size, pixels) = reduced_rgba8(self.size, |i| source.get(i), most, color_space);
        Self {
            size,
            ..self.with_pixels(pixels)
        }
    }

    /// The same picture with other pixels.
    pub fn with_pixels(&self, pixels: Vec<[u8; 4]>) -> Self {
        Self {
            pixels,
            words: None,
            ..*self
        }
    }

    /// Adds the blue of a normal map whose file has red and green alone: the Z of a unit vector.
    pub fn complete_normals(&mut self) {
        if !self.is_red_green {
            return;
        }
        for [r, g, b, _] in &mut self.pixels {
            *b = normal_blue([*r, *g]);
        }
        self.is_red_green = false;
    }

    /// Returns whether any pixel is not opaque.
    pub fn is_transparent(&self) -> bool {
        self.has_alpha && self.pixels.iter().any(|p| p[3] != 255)
    }

    pub fn is_gray(&self) -> bool {
        self.content == Content::Gray
    }

    pub fn write_png(&self, path: &Path) -> Result<(), Error> {
        let [width, height] = self.size;
        let image: Option<DynamicImage> = if self.is_gray() {
            let gray = self.pixels.iter().map(|p| p[0]).collect();
            GrayImage::from_raw(width, height, gray).map(Into::into)
        } else if self.has_alpha {
            let rgba = self.pixels.as_flattened().to_vec();
            RgbaImage::from_raw(width, height, rgba).map(Into::into)
        } else {
            let rgb = self
                .pixels
                .iter()
                .flat_map(|p| [p[0], p[1], p[2]])
                .collect();
            RgbImage::from_raw(width, height, rgb).map(Into::into)
        };
        let mut png = Cursor::new(Vec::new());
        image
            .expect("as many pixels as the size says")
            .write_to(&mut png, ImageFormat::Png)
            .map_err(|e| Error::file(path, format_args!("cannot be encoded as PNG: {e}")))?;
        files::write(path, png.get_ref())
    }
}

//! Pixels from image files and from wavelet textures.

use std::{io::Cursor, path::Path};

use bevy_wavelet_tex::codec::{
    angle::normal_blue,
    decoder::decode,
    image::{ColorSpace, Content, WaveletImage},
    reduce::reduced_rgba8,
    source::Pixels,
};
use image::{DynamicImage, ExtendedColorType, ImageFormat};

use crate::{error::Error, files};

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
    /// Takes a decoded image. Only KTX2 states a colour space, and has red and green alone.
    pub fn from_image(
        image: DynamicImage,
        color_space: Option<ColorSpace>,
        is_red_green: bool,
    ) -> Self {
        let color = image.color();
        let content = if color.has_color() {
            Content::Color
        } else {
            Content::Gray
        };
        let is_wide = color.bytes_per_pixel() == 2 * color.channel_count();
        Self {
            size: [image.width(), image.height()],
            words: is_wide.then(|| image.to_rgba16().pixels().map(|p| p.0).collect()),
            pixels: image.into_rgba8().pixels().map(|p| p.0).collect(),
            has_alpha: color.has_alpha(),
            content,
            color_space,
            is_red_green,
        }
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
        let (color, channels) = match (self.is_gray(), self.has_alpha) {
            (true, _) => (ExtendedColorType::L8, 1),
            (false, true) => (ExtendedColorType::Rgba8, 4),
            (false, false) => (ExtendedColorType::Rgb8, 3),
        };
        let bytes = self.pixels.iter().flat_map(|p| &p[..channels]);
        let bytes: Vec<u8> = bytes.copied().collect();
        let mut png = Cursor::new(Vec::new());
        image::write_buffer_with_format(&mut png, &bytes, width, height, color, ImageFormat::Png)
            .map_err(|e| Error::file(path, format_args!("cannot be encoded as PNG: {e}")))?;
        files::write(path, png.get_ref())
    }
}

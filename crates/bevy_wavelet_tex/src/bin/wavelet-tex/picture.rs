//! Pixels from image files and from wavelet textures.

use std::{io::Cursor, path::Path};

use bevy_wavelet_tex::codec::{
    angle::normal_blue,
    decoder::decode,
    image::{ColorSpace, Content, WaveletImage},
    reduce::reduced_rgba8,
    settings::GrayChannel,
    source::Pixels,
};
use image::DynamicImage;

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
    /// What is in the file and not in the pixels.
    pub warnings: Vec<String>,
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
            warnings: Vec::new(),
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
            warnings: Vec::new(),
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
            warnings: Vec::new(),
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

    /// RGBA of a pixel, in 8-bit units.
    pub fn at(&self, i: usize) -> [f64; 4] {
        match &self.words {
            Some(words) => words[i].map(|v| f64::from(v) / 257.0),
            None => self.pixels[i].map(f64::from),
        }
    }

    /// Returns whether any pixel is not opaque.
    pub fn is_transparent(&self) -> bool {
        self.has_alpha && self.pixels.iter().any(|p| p[3] != 255)
    }

    /// Returns whether alpha cuts parts out: few of its pixels are neither clear nor opaque.
    pub fn is_cut_out(&self) -> bool {
        let between = self
            .pixels
            .iter()
            .filter(|p| (16..240).contains(&p[3]))
            .count();
        between * 10 < self.pixels.len()
    }

    /// Returns whether the shape of a mask is in alpha: red has none.
    pub fn has_shape_in_alpha(&self) -> bool {
        self.is_transparent() && self.pixels.iter().all(|p| p[0] == self.pixels[0][0])
    }

    /// Returns whether nearly all pixels are normals: vectors of about unit length that point outward.
    pub fn has_normals(&self) -> bool {
        let is_normal = |[r, g, b, _]: &&[u8; 4]| {
            let [x, y, z] = [r, g, b].map(|v| f32::from(*v) / 127.5 - 1.0);
            z > -0.1 && (0.7..1.3).contains(&(x * x + y * y + z * z).sqrt())
        };
        let normals = self.pixels.iter().filter(is_normal).count();
        self.is_red_green || normals * 10 >= self.pixels.len() * 9
    }

    /// Makes the picture a gray one of the channel that an encoder takes. Luma stays in the pixels.
    pub fn take_channel(&mut self, channel: GrayChannel) {
        let index = match channel {
            GrayChannel::Luma => return,
            GrayChannel::Red => 0,
            GrayChannel::Alpha => 3,
        };
        self.pixels
            .iter_mut()
            .for_each(|p| *p = [p[index], p[index], p[index], 255]);
        for p in self.words.iter_mut().flatten() {
            *p = [p[index], p[index], p[index], u16::MAX];
        }
        (self.content, self.has_alpha) = (Content::Gray, false);
    }

    pub fn is_gray(&self) -> bool {
        self.content == Content::Gray
    }

    pub fn write_png(&self, path: &Path) -> Result<(), Error> {
        let [width, height] = self.size;
        let (color, channels) = match (self.is_gray(), self.has_alpha) {
            (true, _) => (png::ColorType::Grayscale, 1),
            (false, true) => (png::ColorType::Rgba, 4),
            (false, false) => (png::ColorType::Rgb, 3),
        };
        let bytes = self.pixels.iter().flat_map(|p| &p[..channels]);
        let bytes: Vec<u8> = bytes.copied().collect();
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, width, height);
        encoder.set_color(color);
        let written = encoder
            .add_text_chunk(SOFTWARE.0.into(), SOFTWARE.1.into())
            .and_then(|()| encoder.write_header())
            .and_then(|mut writer| writer.write_image_data(&bytes));
        written.map_err(|e| Error::file(path, format_args!("cannot be encoded as PNG: {e}")))?;
        files::write(path, &file)
    }
}

/// The text in the PNGs of this tool, by which it knows which of them it may overwrite.
const SOFTWARE: (&str, &str) = ("Software", "wavelet-tex decode");

/// Returns whether a file is a PNG that this tool wrote.
pub fn is_own_png(bytes: &[u8]) -> bool {
    let reader = png::Decoder::new(Cursor::new(bytes)).read_info();
    reader.is_ok_and(|reader| {
        let mut texts = reader.info().uncompressed_latin1_text.iter();
        texts.any(|text| (&*text.keyword, &*text.text) == SOFTWARE)
    })
}

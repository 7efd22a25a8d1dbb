//! Pixels from PNGs and from wavelet textures.

use std::{io::Cursor, path::Path};

use bevy_wavelet_tex::{
    codec::{
        decoder::decode,
        image::{ColorSpace, Content, WaveletImage},
        layout::MAX_SIZE,
        reduce::reduced_rgba8,
        source::Pixels,
    },
    file,
};
use image::{
    ColorType, DynamicImage, GrayImage, ImageDecoder, ImageError, ImageFormat, Limits, RgbImage,
    RgbaImage, codecs::png::PngDecoder,
};

use crate::{error::Error, files};

const PNG_SIGNATURE: &[u8] = b"\x89PNG\r\n\x1a\n";

/// The pixels of a PNG or of a texture.
pub struct Picture {
    pub size: [u32; 2],
    /// RGBA of 8 bits, row by row from the top; gray is repeated in three channels.
    pub pixels: Vec<[u8; 4]>,
    /// RGBA of 16 bits, where the image has 16 bits a channel.
    words: Option<Vec<[u16; 4]>>,
    /// Whether the picture has an alpha channel.
    pub has_alpha: bool,
    pub content: Content,
}

impl Picture {
    /// Reads a PNG. Its content is gray or colour, since a PNG cannot mark a normal map.
    pub fn read_png(path: &Path) -> Result<Self, Error> {
        Self::from_png(path, files::read(path)?)
    }

    /// Reads a PNG or the largest level of a texture, which differ in their first bytes.
    pub fn read_any(path: &Path) -> Result<Self, Error> {
        let bytes = files::read(path)?;
        if bytes.starts_with(PNG_SIGNATURE) {
            return Self::from_png(path, bytes);
        }
        match file::read(&bytes) {
            Ok(texture) => Ok(Self::from_texture(&texture, 0)),
            Err(file::ReadError::Magic) => Err(Error::file(
                path,
                "neither a PNG nor a wavelet texture: convert it to PNG first",
            )),
            Err(error) => Err(Error::file(path, error)),
        }
    }

    pub fn from_png(path: &Path, bytes: Vec<u8>) -> Result<Self, Error> {
        let fail = |problem: String| Error::file(path, problem);
        if !bytes.starts_with(PNG_SIGNATURE) {
            return Err(fail(match file::read(&bytes) {
                Err(file::ReadError::Magic) => "not a PNG: convert it to PNG first".into(),
                _ => {
                    "a wavelet texture, not a PNG: decode it with `wavelet-tex decode` first".into()
                }
            }));
        }
        // The size is checked before the decoder does, because its message does not contain the
        // size.
        if let Some([width, height]) = png_size(&bytes).filter(|s| s.iter().any(|&s| s > MAX_SIZE))
        {
            return Err(fail(format!(
                "an image of {width} x {height} pixels: both sides must be 1 to {MAX_SIZE}"
            )));
        }
        let damaged = |e: ImageError| fail(format!("the PNG cannot be decoded: {e}"));
        let mut limits = Limits::default();
        limits.max_image_width = Some(MAX_SIZE);
        limits.max_image_height = Some(MAX_SIZE);
        // The largest image is RGBA of 16 bits.
        limits.max_alloc = Some(8 * u64::from(MAX_SIZE).pow(2));
        let decoder = PngDecoder::with_limits(Cursor::new(bytes), limits).map_err(damaged)?;
        let (width, height) = decoder.dimensions();
        let image = DynamicImage::from_decoder(decoder).map_err(damaged)?;
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
            size: [width, height],
            pixels: image.into_rgba8().pixels().map(|p| p.0).collect(),
            words,
            has_alpha: color.has_alpha(),
            content,
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
            has_alpha: self.has_alpha,
            content: self.content,
        }
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

/// Width and height in the header of a PNG.
fn png_size(bytes: &[u8]) -> Option<[u32; 2]> {
    let (fields, []) = bytes.get(12..24)?.as_chunks::<4>() else {
        return None;
    };
    let size = [fields[1], fields[2]].map(u32::from_be_bytes);
    (&fields[0] == b"IHDR").then_some(size)
}

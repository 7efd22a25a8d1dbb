//! 8-bit pixels, from PNGs and from wavelet textures.

use std::{
    io::{self, Cursor, Write},
    path::Path,
};

use bevy_wavelet_tex::{
    codec::{
        decoder::decode,
        image::{Content, WaveletImage},
        layout::MAX_SIZE,
    },
    file,
};
use image::{
    DynamicImage, GrayImage, ImageDecoder, ImageError, ImageFormat, Limits, RgbImage,
    codecs::png::PngDecoder,
};

use crate::{error::Error, files};

const PNG_SIGNATURE: &[u8] = b"\x89PNG\r\n\x1a\n";

/// Pixels, whatever they came from.
pub struct Picture {
    pub size: [u32; 2],
    /// Row by row; gray in all three channels.
    pub pixels: Vec<[u8; 3]>,
    pub content: Content,
}

impl Picture {
    /// Reads a PNG; it is gray or, as far as a PNG can tell, colour.
    pub fn read_png(path: &Path) -> Result<Self, Error> {
        Self::from_png(path, files::read(path)?)
    }

    /// Reads a PNG or the largest level of a texture, told apart by their first bytes.
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

    fn from_png(path: &Path, bytes: Vec<u8>) -> Result<Self, Error> {
        let fail = |problem: String| Error::file(path, problem);
        if !bytes.starts_with(PNG_SIGNATURE) {
            return Err(fail(match file::read(&bytes) {
                Err(file::ReadError::Magic) => "not a PNG: convert it to PNG first".into(),
                _ => "a wavelet texture, not a PNG: `wavelet-tex decode` makes one of it".into(),
            }));
        }
        // Before the decoder, whose own message would not tell the size.
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
        // RGBA of 16 bits.
        limits.max_alloc = Some(8 * u64::from(MAX_SIZE).pow(2));
        let decoder = PngDecoder::with_limits(Cursor::new(bytes), limits).map_err(damaged)?;
        let (width, height) = decoder.dimensions();
        let image = DynamicImage::from_decoder(decoder).map_err(damaged)?;
        let color = image.color();
        if color.has_alpha() && image.to_rgba8().pixels().any(|p| p[3] != 255) {
            let _ = writeln!(
                io::stderr(),
                "warning: {}: the image has transparent pixels; alpha is dropped",
                path.display()
            );
        }
        let content = if color.has_color() {
            Content::Color
        } else {
            Content::Gray
        };
        Ok(Self {
            size: [width, height],
            pixels: image.into_rgb8().pixels().map(|p| p.0).collect(),
            content,
        })
    }

    /// One mip level of a texture.
    pub fn from_texture(texture: &WaveletImage, level: u32) -> Self {
        let decoded = decode(texture, level);
        let rgba = decoded.to_rgba8(texture.content);
        Self {
            size: decoded.size,
            pixels: rgba.into_iter().map(|[r, g, b, _]| [r, g, b]).collect(),
            content: texture.content,
        }
    }

    pub fn is_gray(&self) -> bool {
        self.content == Content::Gray
    }

    pub fn write_png(&self, path: &Path) -> Result<(), Error> {
        let [width, height] = self.size;
        let image: Option<DynamicImage> = if self.is_gray() {
            let gray = self.pixels.iter().map(|p| p[0]).collect();
            GrayImage::from_raw(width, height, gray).map(Into::into)
        } else {
            let rgb = self.pixels.as_flattened().to_vec();
            RgbImage::from_raw(width, height, rgb).map(Into::into)
        };
        let mut png = Cursor::new(Vec::new());
        image
            .expect("as many pixels as the size says")
            .write_to(&mut png, ImageFormat::Png)
            .map_err(|e| Error::file(path, format_args!("cannot be made a PNG: {e}")))?;
        files::write(path, png.get_ref())
    }
}

/// Width and height that the header of a PNG claims.
fn png_size(bytes: &[u8]) -> Option<[u32; 2]> {
    let (fields, []) = bytes.get(12..24)?.as_chunks::<4>() else {
        return None;
    };
    let size = [fields[1], fields[2]].map(u32::from_be_bytes);
    (&fields[0] == b"IHDR").then_some(size)
}

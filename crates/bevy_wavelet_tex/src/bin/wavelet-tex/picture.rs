//! Pixels from image files (PNG, JPEG, WebP, TGA and KTX2) and from wavelet textures.

use std::{io::Cursor, path::Path};

use bevy_wavelet_tex::{
    codec::{
        angle::normal_blue,
        decoder,
        image::{ColorSpace, Content, WaveletImage},
        layout::MAX_SIZE,
        reduce::reduced_rgba8,
        settings::GrayChannel,
        source::Pixels,
    },
    file::{self, zstd},
};
use image::{
    DynamicImage, GrayImage, ImageDecoder, ImageError, ImageFormat, ImageReader, Limits, RgbImage,
    RgbaImage,
};
use ktx2::{Format, Header, LevelIndex, SupercompressionScheme};

use crate::{Error, files};

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
        let decoded = decoder::decode(texture, level);
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

/// Extensions of the image files that are encoded from folders.
pub const EXTENSIONS: &[&str] = &["png", "jpg", "jpeg", "webp", "tga", "ktx2"];

/// The formats, for messages.
const FORMATS: &str = "PNG, JPEG, WebP, TGA or KTX2";

/// Reads an image file. Its content is gray or colour, since none of them marks a normal map.
pub fn read(path: &Path) -> Result<Picture, Error> {
    decode(path, &files::read(path)?)
}

/// Reads an image file or the largest level of a texture, which differ in their first bytes.
pub fn read_any(path: &Path) -> Result<Picture, Error> {
    let bytes = files::read(path)?;
    match file::read(&bytes) {
        Ok(texture) => Ok(Picture::from_texture(&texture, 0)),
        Err(file::ReadError::Magic) => decode(path, &bytes),
        Err(error) => Err(Error::file(path, error)),
    }
}

/// Decodes an image. TGA has no signature and is recognised by its file name; the others by their first
/// bytes.
pub fn decode(path: &Path, bytes: &[u8]) -> Result<Picture, Error> {
    let fail = |problem: String| Error::file(path, problem);
    check_size(ktx2_size(bytes).or_else(|| png_size(bytes))).map_err(fail)?;
    if bytes.starts_with(&KTX2_SIGNATURE) {
        return decode_ktx2(bytes)
            .map_err(|problem| fail(format!("the KTX2 cannot be decoded: {problem}")));
    }
    let format = match image::guess_format(bytes) {
        Ok(format) if format.reading_enabled() => format,
        _ if files::has_extension(path, &["tga"]) => ImageFormat::Tga,
        _ => return Err(fail(unknown(bytes))),
    };
    let name = match format {
        ImageFormat::Jpeg => "JPEG",
        ImageFormat::WebP => "WebP",
        ImageFormat::Tga => "TGA",
        _ => "PNG",
    };
    let damaged = |e: ImageError| fail(format!("the {name} cannot be decoded: {e}"));
    if format == ImageFormat::Jpeg && !is_complete_jpeg(bytes) {
        return Err(fail(
            "the JPEG cannot be decoded: it is cut short, so copy or export it again".into(),
        ));
    }
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = Limits::default();
    // The largest image is RGBA of 16 bits.
    limits.max_alloc = Some(8 * u64::from(MAX_SIZE).pow(2));
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(damaged)?;
    check_size(Some(decoder.dimensions().into())).map_err(fail)?;
    let image = DynamicImage::from_decoder(decoder).map_err(damaged)?;
    let mut picture = Picture::from_image(image, None, false);
    if format == ImageFormat::Png {
        picture.warnings.extend(other_gamma(bytes));
    }
    Ok(picture)
}

/// A warning about a PNG that states another transfer function than that of sRGB, which Bevy ignores, too.
fn other_gamma(bytes: &[u8]) -> Option<String> {
    let reader = png::Decoder::new(Cursor::new(bytes)).read_info().ok()?;
    let info = reader.info();
    let gamma = info.gama_chunk?.into_value();
    let is_usual = info.srgb.is_some() || info.icc_profile.is_some() || (0.4..0.5).contains(&gamma);
    (!is_usual).then(|| {
        format!(
            "its gAMA chunk says {gamma:.3}, but its values are taken as sRGB, as Bevy takes them (--linear \
             takes them as linear)"
        )
    })
}

/// The message about bytes that are no image, with the remedy.
fn unknown(bytes: &[u8]) -> String {
    match file::read(bytes) {
        Err(file::ReadError::Magic) => format!("not a {FORMATS}: convert it to PNG first"),
        _ => "a wavelet texture, not an image: decode it with `wavelet-tex decode` first".into(),
    }
}

/// Refuses a size before memory is allocated for it.
fn check_size(size: Option<[u32; 2]>) -> Result<(), String> {
    match size {
        Some([width, height]) if [width, height].iter().any(|s| !(1..=MAX_SIZE).contains(s)) => {
            Err(format!(
                "an image of {width} x {height} pixels: both sides must be 1 to {MAX_SIZE}"
            ))
        }
        _ => Ok(()),
    }
}

/// Width and height in the header of a PNG, whose decoder refuses a large image without naming them.
fn png_size(bytes: &[u8]) -> Option<[u32; 2]> {
    let (fields, []) = bytes.get(12..24)?.as_chunks::<4>() else {
        return None;
    };
    let size = [fields[1], fields[2]].map(u32::from_be_bytes);
    (&fields[0] == b"IHDR").then_some(size)
}

const START_OF_SCAN: u8 = 0xda;
const END_OF_IMAGE: [u8; 2] = [0xff, 0xd9];

/// Returns whether a JPEG is not cut short, whose missing rows the decoder would fill with gray: the end of the image
/// follows its first scan. The segments before it are skipped,
/// because a thumbnail in one of them has an end of its own; within scans the two bytes do not occur.
fn is_complete_jpeg(bytes: &[u8]) -> bool {
    jpeg_scan(bytes).is_some_and(|scan| scan.windows(2).any(|pair| pair == END_OF_IMAGE))
}

/// The bytes of a JPEG from the first scan on.
fn jpeg_scan(bytes: &[u8]) -> Option<&[u8]> {
    let mut rest = bytes.get(2..)?;
    loop {
        // Any number of 0xff can precede the code of a marker.
        let code = rest
            .iter()
            .position(|byte| *byte != 0xff)
            .filter(|p| *p > 0)?;
        let segment = &rest[code + 1..];
        if rest[code] == START_OF_SCAN {
            return Some(segment);
        }
        let length = u16::from_be_bytes(*segment.first_chunk()?);
        rest = segment.get(usize::from(length.max(2))..)?;
    }
}

const KTX2_SIGNATURE: [u8; 12] = *b"\xabKTX 20\xbb\r\n\x1a\n";

/// Width and height in the header of a KTX2.
fn ktx2_size(bytes: &[u8]) -> Option<[u32; 2]> {
    let header = Header::from_bytes(bytes.first_chunk()?).ok()?;
    Some([header.pixel_width, header.pixel_height])
}

/// Decodes the largest level of a KTX2 of 8 bits a channel, or returns what is wrong with it. The size has been checked.
fn decode_ktx2(bytes: &[u8]) -> Result<Picture, String> {
    let cut = || "it is cut short, so copy or export it again".to_string();
    // The reader of the `ktx2` crate panics on some damaged descriptors, which are not needed here.
    let header = Header::from_bytes(bytes.first_chunk().ok_or_else(cut)?)
        .map_err(|error| error.to_string())?;
    if header.face_count > 1 || header.layer_count > 1 || header.pixel_depth > 1 {
        return Err("it is an array, a cube or a volume: encode each image by itself".into());
    }
    let (channels, color_space) = match header.format {
        Some(Format::R8_UNORM) => (1, ColorSpace::Linear),
        Some(Format::R8_SRGB) => (1, ColorSpace::Srgb),
        Some(Format::R8G8_UNORM) => (2, ColorSpace::Linear),
        Some(Format::R8G8_SRGB) => (2, ColorSpace::Srgb),
        Some(Format::R8G8B8_UNORM) => (3, ColorSpace::Linear),
        Some(Format::R8G8B8_SRGB) => (3, ColorSpace::Srgb),
        Some(Format::R8G8B8A8_UNORM) => (4, ColorSpace::Linear),
        Some(Format::R8G8B8A8_SRGB) => (4, ColorSpace::Srgb),
        other => return Err(refused(other)),
    };
    let entry = bytes[Header::LENGTH..].first_chunk().ok_or_else(cut)?;
    let level = LevelIndex::from_bytes(entry);
    let end = level.byte_offset.checked_add(level.byte_length);
    let data = end.and_then(|end| bytes.get(level.byte_offset as usize..end as usize));
    let data = data.ok_or_else(cut)?;
    let [width, height] = [header.pixel_width, header.pixel_height];
    let length = channels * width as usize * height as usize;
    let texels = match header.supercompression_scheme {
        None => data.to_vec(),
        Some(SupercompressionScheme::Zstandard) => zstd::decompress(data, length)?,
        Some(other) => {
            return Err(format!(
                "its supercompression {other:?} is not supported: write it with Zstandard or without"
            ));
        }
    };
    if texels.len() != length {
        return Err(format!(
            "its largest level has {} bytes instead of {length}",
            texels.len()
        ));
    }
    let image = match channels {
        1 => GrayImage::from_raw(width, height, texels).map(DynamicImage::from),
        2 => {
            let (pairs, _) = texels.as_chunks();
            let rgb = pairs.iter().flat_map(|[r, g]| [*r, *g, 0]).collect();
            RgbImage::from_raw(width, height, rgb).map(DynamicImage::from)
        }
        3 => RgbImage::from_raw(width, height, texels).map(DynamicImage::from),
        _ => RgbaImage::from_raw(width, height, texels).map(DynamicImage::from),
    };
    let image = image.expect("as many texels as the size says");
    let mut picture = Picture::from_image(image, Some(color_space), channels == 2);
    picture.warnings = ktx2_warnings(bytes, &header);
    Ok(picture)
}

/// What a KTX2 says of its texels that is ignored, as Bevy ignores it.
fn ktx2_warnings(bytes: &[u8], header: &Header) -> Vec<String> {
    let part = |start: u32, length: u32| {
        let start = start as usize;
        bytes
            .get(start..start.saturating_add(length as usize))
            .unwrap_or(&[])
    };
    let index = &header.index;
    let mut warnings = Vec::new();
    let mut keys = part(index.kvd_byte_offset, index.kvd_byte_length);
    while let Some((length, rest)) = keys.split_first_chunk() {
        let length = u32::from_le_bytes(*length) as usize;
        let Some(entry) = rest.get(..length) else {
            break;
        };
        let text = String::from_utf8_lossy(entry);
        let (key, value) = text.split_once('\0').unwrap_or((&text, ""));
        let value = value.trim_end_matches('\0');
        let is_usual = match key {
            "KTXorientation" => value == "rd",
            "KTXswizzle" => value == "rgba",
            _ => true,
        };
        if !is_usual {
            warnings.push(format!(
                "its {key} is {value}, which is ignored, as Bevy ignores it"
            ));
        }
        keys = rest.get(length.next_multiple_of(4)..).unwrap_or(&[]);
    }
    // The flags of the basic descriptor, of which bit 0 is that of premultiplied alpha.
    let descriptor = part(index.dfd_byte_offset, index.dfd_byte_length);
    if descriptor.get(15).is_some_and(|flags| flags & 1 != 0) {
        warnings.push("its alpha is premultiplied, but it is taken as straight alpha".into());
    }
    warnings
}

/// Why a format of a KTX2 is refused, and what to do.
fn refused(format: Option<Format>) -> String {
    let Some(format) = format else {
        return "it is compressed by Basis Universal: encode the original image instead".into();
    };
    let name = format!("{format:?}");
    if name.contains("BLOCK") {
        format!("its format {name} is block-compressed: encode the original image instead")
    } else {
        format!(
            "its format {name} is not supported: convert it to 8 bits a channel (R8, RG8, RGB8 or RGBA8)"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_end_inside_a_segment_is_no_end() {
        let head = [0xff, 0xd8, 0xff, 0xe1, 0, 6, 0xff, 0xd9, 1, 2];
        let scan = [0xff, 0xff, 0xda, 0, 2, 7, 0xff, 0, 8];
        let cut = [&head[..], &scan].concat();
        assert!(!is_complete_jpeg(&cut));
        assert!(is_complete_jpeg(&[&cut[..], &END_OF_IMAGE].concat()));
        for length in 0..cut.len() {
            assert!(!is_complete_jpeg(&cut[..length]), "{length}");
        }
    }
}

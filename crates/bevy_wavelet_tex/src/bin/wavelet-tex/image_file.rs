//! Decoding of image files: PNG, JPEG, WebP, TGA and KTX2.

use std::{io::Cursor, path::Path};

use bevy_wavelet_tex::{codec::layout::MAX_SIZE, file};
use image::{DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader, Limits};

use crate::{error::Error, files, ktx2, picture::Picture};

/// Extensions of the image files that are encoded from folders.
pub const EXTENSIONS: &[&str] = &["png", "jpg", "jpeg", "webp", "tga", "ktx2"];

/// The formats, for messages.
pub const FORMATS: &str = "PNG, JPEG, WebP, TGA or KTX2";

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
    check_size(ktx2::size(bytes).or_else(|| png_size(bytes))).map_err(fail)?;
    if bytes.starts_with(&ktx2::SIGNATURE) {
        return ktx2::decode(bytes)
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

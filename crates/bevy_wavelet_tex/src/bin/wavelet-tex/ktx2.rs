//! KTX2 images of 8 bits a channel.

use ::ktx2::{Format, Header, LevelIndex, SupercompressionScheme};
use bevy_wavelet_tex::{codec::image::ColorSpace, file::zstd};
use image::{DynamicImage, GrayImage, RgbImage, RgbaImage};

use crate::picture::Picture;

pub const SIGNATURE: [u8; 12] = *b"\xabKTX 20\xbb\r\n\x1a\n";

/// Width and height in the header.
pub fn size(bytes: &[u8]) -> Option<[u32; 2]> {
    let header = Header::from_bytes(bytes.first_chunk()?).ok()?;
    Some([header.pixel_width, header.pixel_height])
}

/// Decodes the largest level, or returns what is wrong with it. The size has been checked.
pub fn decode(bytes: &[u8]) -> Result<Picture, String> {
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
    picture.warnings = warnings(bytes, &header);
    Ok(picture)
}

/// What a file says of its texels that is ignored, as Bevy ignores it.
fn warnings(bytes: &[u8], header: &Header) -> Vec<String> {
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

/// Why a format is refused, and what to do.
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

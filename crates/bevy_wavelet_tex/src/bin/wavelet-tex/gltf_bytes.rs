//! The bytes in a glTF file: the chunks of a GLB, buffers and URIs.

use std::{borrow::Cow, path::Path};

use base64::prelude::{BASE64_STANDARD, Engine};
use percent_encoding::percent_decode_str;
use serde_json::Value;

use crate::{error::Error, files};

/// The JSON and, if there is one, the binary chunk of a GLB file.
pub fn chunks(bytes: &[u8]) -> Option<(&[u8], Option<&[u8]>)> {
    let u32_at = |at: usize| Some(u32::from_le_bytes(*bytes.get(at..)?.first_chunk()?) as usize);
    let chunk = |at: usize, kind: &[u8; 4]| {
        let length = u32_at(at)?;
        (bytes.get(at + 4..at + 8)? == kind).then_some(())?;
        bytes.get(at + 8..(at + 8).checked_add(length)?)
    };
    let json = chunk(12, b"JSON")?;
    Some((json, chunk(20 + json.len(), b"BIN\0")))
}

/// The bytes of an image in a buffer.
pub fn from_buffer(
    json: &Value,
    image: &Value,
    binary: Option<&[u8]>,
    path: &Path,
) -> Result<Option<Vec<u8>>, Error> {
    let Some(view) = image["bufferView"].as_u64() else {
        return Ok(None);
    };
    let view = &json["bufferViews"][view as usize];
    let number = |name: &str| view[name].as_u64().map(|v| v as usize);
    let (Some(buffer), Some(length)) = (number("buffer"), number("byteLength")) else {
        return Ok(None);
    };
    let bytes: Option<Cow<[u8]>> = match json["buffers"][buffer]["uri"].as_str() {
        None => binary.map(Cow::from),
        Some(uri) if uri.starts_with("data:") => from_data_uri(uri).map(Cow::from),
        Some(uri) => {
            Some(files::read(&path.with_file_name("").join(&*percent_decoded(uri)))?.into())
        }
    };
    let offset = number("byteOffset").unwrap_or(0);
    let range = offset..offset.saturating_add(length);
    Ok(bytes.and_then(|bytes| bytes.get(range).map(<[u8]>::to_vec)))
}

/// The bytes of a base64 data URI.
pub fn from_data_uri(uri: &str) -> Option<Vec<u8>> {
    let (_, text) = uri.split_once(";base64,")?;
    BASE64_STANDARD.decode(text).ok()
}

pub fn percent_decoded(uri: &str) -> Cow<'_, str> {
    percent_decode_str(uri).decode_utf8_lossy()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn data_and_percent_come_apart() {
        assert_eq!(
            from_data_uri("data:image/png;base64,aGVsbG8="),
            Some(b"hello".to_vec())
        );
        assert_eq!(from_data_uri("data:image/png;base64,a*"), None);
        assert_eq!(from_data_uri("data:,plain"), None);
        assert_eq!(percent_decoded("a%20b%zz.png"), "a b%zz.png");
    }

    #[test]
    fn no_cut_glb_panics() {
        let mut glb = b"glTF\x02\0\0\0\0\0\0\0".to_vec();
        glb.extend(2u32.to_le_bytes());
        glb.extend(b"JSON{}");
        for length in 0..=glb.len() {
            let found = chunks(&glb[..length]);
            assert_eq!(found.is_some(), length == glb.len(), "{length}");
        }
        glb[12..16].copy_from_slice(&u32::MAX.to_le_bytes());
        assert!(chunks(&glb).is_none());
    }
}

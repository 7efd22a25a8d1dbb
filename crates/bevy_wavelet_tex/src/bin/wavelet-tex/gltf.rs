//! The images of a glTF file, and what the materials use them for.
//!
//! Only the images and the textures that the maps of the materials name are parsed.

use std::{
    borrow::Cow,
    path::{Path, PathBuf},
};

use base64::prelude::{BASE64_STANDARD, Engine};
use percent_encoding::percent_decode_str;
use serde_json::Value;

use crate::{
    Error,
    args::{AlphaArg, Role},
    files,
};

/// Extensions of glTF files.
pub const EXTENSIONS: &[&str] = &["gltf", "glb"];

/// What a material uses an image for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Use {
    pub role: Role,
    /// Whether the material has a use for alpha.
    pub alpha: AlphaArg,
    /// The cutoff of a material that cuts parts out.
    pub cutoff: Option<f32>,
}

/// A texture that a material uses.
pub struct Texture {
    /// Its index, by which Bevy's loader labels it.
    pub index: usize,
    /// The index of its image.
    pub image: usize,
    /// Path of the image relative to the glTF file, where it has a file of its own.
    pub file: Option<PathBuf>,
    pub what: Use,
}

/// The maps of a material that wavelet textures can be: their JSON pointers and the kind of data in them.
const MAPS: [(&str, Role); 5] = [
    ("/pbrMetallicRoughness/baseColorTexture/index", Role::Color),
    ("/emissiveTexture/index", Role::Color),
    ("/normalTexture/index", Role::Normal),
    (
        "/pbrMetallicRoughness/metallicRoughnessTexture/index",
        Role::Data,
    ),
    ("/occlusionTexture/index", Role::Occlusion),
];

/// A glTF file.
pub struct Gltf {
    path: PathBuf,
    json: Value,
    binary: Option<Vec<u8>>,
}

impl Gltf {
    pub fn read(path: &Path) -> Result<Self, Error> {
        let bytes = files::read(path)?;
        let fail = |problem: String| Error::file(path, problem);
        let (json, binary) = if bytes.starts_with(b"glTF") {
            chunks(&bytes).ok_or_else(|| fail("the glTF file is cut short or damaged".into()))?
        } else {
            (bytes.as_slice(), None)
        };
        Ok(Self {
            path: path.to_path_buf(),
            json: serde_json::from_slice(json)
                .map_err(|e| fail(format!("the glTF is not valid JSON: {e}")))?,
            binary: binary.map(<[u8]>::to_vec),
        })
    }

    /// The textures that the materials use, each once for each use, or why they cannot be encoded.
    pub fn textures(&self) -> Vec<Result<Texture, Error>> {
        let materials = self.json["materials"].as_array();
        let mut all = Vec::new();
        for material in materials.into_iter().flatten() {
            for (pointer, role) in MAPS {
                if let Some(index) = material.pointer(pointer).and_then(Value::as_u64) {
                    let what = use_in(material, pointer == MAPS[0].0, role);
                    all.push(self.texture(index as usize, what));
                }
            }
        }
        all
    }

    /// The names of the material extensions with maps, which keep their own images.
    pub fn others(&self) -> Vec<String> {
        let materials = self.json["materials"].as_array();
        let extensions = materials
            .into_iter()
            .flatten()
            .filter_map(|material| material["extensions"].as_object())
            .flatten();
        let has_map = |value: &Value| {
            let fields = value.as_object().into_iter().flatten();
            fields
                .into_iter()
                .any(|(name, _)| name.ends_with("Texture"))
        };
        let names = extensions.filter(|(_, value)| has_map(value));
        let mut names: Vec<String> = names.map(|(name, _)| name.clone()).collect();
        names.sort();
        names.dedup();
        names
    }

    fn texture(&self, index: usize, what: Use) -> Result<Texture, Error> {
        let image = self.json["textures"][index]["source"].as_u64();
        let image = image.ok_or_else(|| {
            Error::file(
                &self.path,
                format_args!(
                    "its texture {index} has no image of a core glTF format: export it with PNG or JPEG"
                ),
            )
        })? as usize;
        let uri = self.json["images"][image]["uri"].as_str();
        let file = uri.filter(|uri| !uri.starts_with("data:"));
        Ok(Texture {
            index,
            image,
            file: file.map(|uri| PathBuf::from(&*percent_decoded(uri))),
            what,
        })
    }

    /// The bytes of an image without a file of its own.
    pub fn image(&self, image: usize) -> Result<Vec<u8>, Error> {
        let entry = &self.json["images"][image];
        let bytes = match entry["uri"].as_str() {
            Some(uri) => from_data_uri(uri),
            None => from_buffer(&self.json, entry, self.binary.as_deref(), &self.path)?,
        };
        bytes.ok_or_else(|| Error::file(&self.path, format_args!("its image {image} has no bytes")))
    }
}

/// The use of a map in a material. glTF has alpha in the map of the base colour alone.
fn use_in(material: &Value, is_base_color: bool, role: Role) -> Use {
    let mode = material["alphaMode"].as_str().filter(|_| is_base_color);
    let cutoff = material["alphaCutoff"].as_f64().unwrap_or(0.5) as f32;
    Use {
        role,
        alpha: match mode {
            Some("MASK" | "BLEND") => AlphaArg::Keep,
            _ => AlphaArg::Drop,
        },
        cutoff: (mode == Some("MASK")).then_some(cutoff.clamp(1.0 / 255.0, 1.0)),
    }
}

/// The JSON and, if there is one, the binary chunk of a GLB file.
fn chunks(bytes: &[u8]) -> Option<(&[u8], Option<&[u8]>)> {
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
fn from_buffer(
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
fn from_data_uri(uri: &str) -> Option<Vec<u8>> {
    let (_, text) = uri.split_once(";base64,")?;
    BASE64_STANDARD.decode(text).ok()
}

fn percent_decoded(uri: &str) -> Cow<'_, str> {
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

//! The images of a glTF file, with the role that each has in the materials.
//!
//! Only the images and the textures that the maps of the materials name are parsed.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

use serde_json::Value;

use crate::{
    choices::Role,
    error::Error,
    files,
    gltf_bytes::{chunks, from_buffer, from_data_uri, percent_decoded},
};

/// Extensions of glTF files.
pub const EXTENSIONS: &[&str] = &["gltf", "glb"];

/// An image that is used by a material.
pub struct GltfImage {
    /// The index of the first texture that uses it, by which Bevy's loader labels it.
    pub index: usize,
    /// Kind of data in the image.
    pub role: Role,
    /// Path of the image, where it has a file of its own.
    pub file: Option<PathBuf>,
    /// Bytes of the image file.
    pub bytes: Vec<u8>,
}

/// The maps of a material: their JSON pointers and the kind of data in them. Where an image has two
/// roles (occlusion is often a channel of metallic-roughness), the first map in this order decides.
const MAPS: [(&str, Role); 5] = [
    ("/pbrMetallicRoughness/baseColorTexture/index", Role::Color),
    ("/emissiveTexture/index", Role::Color),
    ("/normalTexture/index", Role::Normal),
    (
        "/pbrMetallicRoughness/metallicRoughnessTexture/index",
        Role::Data,
    ),
    ("/occlusionTexture/index", Role::Mask),
];

/// Reads the images that the materials of a file use, in the order of their textures' indices. An image with a
/// file of its own comes once, however many textures use it.
pub fn read(path: &Path) -> Result<Vec<GltfImage>, Error> {
    let bytes = files::read(path)?;
    let fail = |problem: String| Error::file(path, problem);
    let (json, binary) = if bytes.starts_with(b"glTF") {
        chunks(&bytes).ok_or_else(|| fail("the glTF file is cut short or damaged".into()))?
    } else {
        (bytes.as_slice(), None)
    };
    let json: Value = serde_json::from_slice(json)
        .map_err(|e| fail(format!("the glTF is not valid JSON: {e}")))?;
    let mut roles: BTreeMap<usize, (u64, Role)> = BTreeMap::new();
    for (pointer, role) in MAPS {
        for material in json["materials"].as_array().into_iter().flatten() {
            let Some(texture) = material.pointer(pointer).and_then(Value::as_u64) else {
                continue;
            };
            let image = json["textures"][texture as usize]["source"].as_u64();
            let image = image.ok_or_else(|| {
                fail(format!(
                    "its texture {texture} has no image of a core glTF format: export it with PNG or JPEG"
                ))
            })?;
            roles.entry(texture as usize).or_insert((image, role));
        }
    }
    let found = roles.into_iter().map(|(index, (source, role))| {
        let image = &json["images"][source as usize];
        let (file, bytes) = match image["uri"].as_str() {
            Some(uri) if uri.starts_with("data:") => (None, from_data_uri(uri)),
            Some(uri) => {
                let file = path.with_file_name("").join(&*percent_decoded(uri));
                let bytes = files::read(&file)?;
                (Some(file), Some(bytes))
            }
            None => (None, from_buffer(&json, image, binary, path)?),
        };
        let bytes =
            bytes.ok_or_else(|| fail(format!("the image of its texture {index} has no bytes")))?;
        Ok(GltfImage {
            index,
            role,
            file,
            bytes,
        })
    });
    let mut images: Vec<GltfImage> = Vec::new();
    for image in found {
        let image: GltfImage = image?;
        let is_same = |other: &GltfImage| image.file.is_some() && other.file == image.file;
        if !images.iter().any(is_same) {
            images.push(image);
        }
    }
    Ok(images)
}

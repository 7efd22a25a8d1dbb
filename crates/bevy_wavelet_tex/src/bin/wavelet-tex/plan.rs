//! What a run encodes and where it writes it, known before anything is encoded: an output has one image, an
//! image in several roles has what serves them all or an output for each, and no output is an original.
//!
//! Of a glTF file only the images and the textures that the maps of the materials name are parsed.

use std::{
    borrow::Cow,
    collections::HashMap,
    path::{Path, PathBuf},
};

use base64::prelude::{BASE64_STANDARD, Engine};
use bevy_wavelet_tex::file::EXTENSION;
use percent_encoding::percent_decode_str;
use serde_json::Value;

use crate::{
    Error,
    args::{AlphaArg, Role},
    files::{self, Destination, Input, Outputs},
    settings::Patterns,
};

/// Where the bytes of an image are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Origin {
    File(PathBuf),
    Gltf { file: PathBuf, image: usize },
}

/// Why an image has its role.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RoleSource {
    Argument,
    Gltf,
    Name,
}

/// An image and its output.
#[derive(Clone, Debug)]
pub struct Task {
    pub origin: Origin,
    /// The name of the image for people.
    pub label: PathBuf,
    pub output: PathBuf,
    pub role: Option<(Role, RoleSource)>,
    pub alpha: AlphaArg,
    pub cutoff: Option<f32>,
}

/// An image with all of its uses.
struct Image {
    origin: Origin,
    label: PathBuf,
    relative: PathBuf,
    output: PathBuf,
    uses: Vec<Use>,
}

/// What a run does.
#[derive(Default)]
pub struct Plan {
    pub tasks: Vec<Task>,
    pub errors: Vec<Error>,
    /// glTF files with maps that stay as they are, and what these belong to, or without maps.
    pub left: Vec<(PathBuf, String)>,
    images: Vec<Image>,
    by_output: HashMap<PathBuf, usize>,
}

impl Plan {
    /// Plans the encoding of images and of those in glTF files. `role` is that of all images that no glTF file
    /// uses.
    pub fn new(
        inputs: &[Input],
        errors: Vec<Error>,
        destination: &Destination,
        role: Option<Role>,
        patterns: &Patterns,
    ) -> Self {
        let mut plan = Self {
            errors,
            ..Self::default()
        };
        let mut outputs = Outputs::default();
        for input in inputs {
            outputs.protect(&input.path);
            let added = if files::has_extension(&input.path, GLTF_EXTENSIONS) {
                plan.add_gltf(input, destination)
            } else {
                let origin = Origin::File(files::identity(&input.path));
                plan.add_file(input, origin, destination, None)
            };
            plan.errors.extend(added.err());
        }
        for image in std::mem::take(&mut plan.images) {
            if let Origin::File(path) = &image.origin {
                outputs.protect(path);
            }
            let tasks = image.tasks(role, patterns);
            plan.tasks.extend(tasks);
        }
        let mut tasks = std::mem::take(&mut plan.tasks);
        tasks.retain(|task| match outputs.take(&task.output, &task.label) {
            Ok(()) => true,
            Err(error) => {
                plan.errors.push(error);
                false
            }
        });
        plan.tasks = tasks;
        plan
    }

    fn add_file(
        &mut self,
        input: &Input,
        origin: Origin,
        destination: &Destination,
        what: Option<Use>,
    ) -> Result<(), Error> {
        self.add(Image {
            origin,
            label: input.path.clone(),
            relative: input.relative.clone(),
            output: destination.of(input, EXTENSION)?,
            uses: what.into_iter().collect(),
        })
    }

    /// Adds an image, or the uses of one to that which is there already.
    fn add(&mut self, image: Image) -> Result<(), Error> {
        let key = files::identity(&image.output);
        let Some(&index) = self.by_output.get(&key) else {
            self.by_output.insert(key, self.images.len());
            self.images.push(image);
            return Ok(());
        };
        let known = &mut self.images[index];
        if known.origin == image.origin {
            known.uses.extend(image.uses);
            return Ok(());
        }
        Err(Error::file(
            &image.label,
            format_args!(
                "its result {} is that of {}: write them to different folders",
                image.output.display(),
                known.label.display()
            ),
        ))
    }

    /// Adds all images that the materials of a glTF file use.
    fn add_gltf(&mut self, input: &Input, destination: &Destination) -> Result<(), Error> {
        let gltf = Gltf::read(&input.path)?;
        let others = gltf.others().join(", ");
        if !others.is_empty() || gltf.textures().is_empty() {
            self.left.push((input.path.clone(), others));
        }
        let mut failed = Vec::new();
        for texture in gltf.textures() {
            let added = texture.and_then(|texture| match &texture.file {
                // An image with a file of its own keeps its name and is shared by all glTF files that
                // use it.
                Some(file) => {
                    let beside = |path: &Path| path.with_file_name("").join(file);
                    let own = Input {
                        path: beside(&input.path),
                        relative: beside(&input.relative),
                    };
                    let origin = Origin::File(files::identity(&own.path));
                    self.add_file(&own, origin, destination, Some(texture.what))
                }
                None => {
                    // `WaveletGltf` looks for this name. `with_extension` would replace the number of the
                    // texture.
                    let name = |path: &Path| {
                        let mut name = path.as_os_str().to_os_string();
                        name.push(format!(".Texture{}.{EXTENSION}", texture.index));
                        PathBuf::from(name)
                    };
                    let output = destination.named(&Input {
                        path: name(&input.path),
                        relative: name(&input.relative),
                    })?;
                    let label = format!("{} texture {}", input.path.display(), texture.index);
                    self.add(Image {
                        origin: Origin::Gltf {
                            file: input.path.clone(),
                            image: texture.image,
                        },
                        label: label.into(),
                        relative: input.relative.clone(),
                        output,
                        uses: vec![texture.what],
                    })
                }
            });
            failed.extend(added.err());
        }
        // A material can have the same problem in several maps.
        failed.dedup_by_key(|error| error.to_string());
        self.errors.extend(failed);
        Ok(())
    }
}

impl Image {
    /// One task, or one for each role that no other serves.
    fn tasks(self, role: Option<Role>, patterns: &Patterns) -> Vec<Task> {
        let task = |role, output, uses: &[&Use]| Task {
            origin: self.origin.clone(),
            label: self.label.clone(),
            output,
            role,
            alpha: match uses {
                [] => AlphaArg::Auto,
                uses if uses.iter().any(|u| u.alpha == AlphaArg::Keep) => AlphaArg::Keep,
                _ => AlphaArg::Drop,
            },
            cutoff: uses.iter().find_map(|u| u.cutoff),
        };
        if self.uses.is_empty() {
            let by_name = || Some((patterns.role(&self.relative)?, RoleSource::Name));
            let role = role.map(|role| (role, RoleSource::Argument));
            let role = role.or_else(by_name);
            return vec![task(role, self.output.clone(), &[])];
        }
        let mut roles: Vec<Role> = self.uses.iter().map(|u| u.role).collect();
        roles.sort();
        roles.dedup();
        // Occlusion is the red channel of metallic-roughness, and linear as it is.
        if roles.contains(&Role::Data) {
            roles.retain(|role| *role != Role::Occlusion);
        }
        let of_role = |(index, &role): (usize, &Role)| {
            let uses: Vec<&Use> = self.uses.iter().filter(|u| u.role == role).collect();
            let output = match index {
                0 => self.output.clone(),
                _ => self
                    .output
                    .with_extension(format!("{}.{EXTENSION}", role.name())),
            };
            task(Some((role, RoleSource::Gltf)), output, &uses)
        };
        roles.iter().enumerate().map(of_role).collect()
    }
}

/// Extensions of glTF files.
pub const GLTF_EXTENSIONS: &[&str] = &["gltf", "glb"];

/// The use of an image by a material.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Use {
    role: Role,
    /// Whether the material has a use for alpha.
    alpha: AlphaArg,
    /// The cutoff of a material that cuts parts out.
    cutoff: Option<f32>,
}

/// A texture that a material uses.
struct Texture {
    /// Its index, by which Bevy's loader labels it.
    index: usize,
    /// The index of its image.
    image: usize,
    /// Path of the image relative to the glTF file, where it has a file of its own.
    file: Option<PathBuf>,
    what: Use,
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
    fn textures(&self) -> Vec<Result<Texture, Error>> {
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
    fn others(&self) -> Vec<String> {
        let materials = self.json["materials"].as_array();
        let extensions = materials
            .into_iter()
            .flatten()
            .filter_map(|material| material["extensions"].as_object())
            .flatten();
        let has_map = |value: &Value| {
            let mut fields = value.as_object().into_iter().flatten();
            fields.any(|(name, _)| name.ends_with("Texture"))
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
            None => self.bytes_in_buffer(entry)?,
        };
        bytes.ok_or_else(|| Error::file(&self.path, format_args!("its image {image} has no bytes")))
    }

    /// The bytes of an image in a buffer.
    fn bytes_in_buffer(&self, image: &Value) -> Result<Option<Vec<u8>>, Error> {
        let Some(view) = image["bufferView"].as_u64() else {
            return Ok(None);
        };
        let view = &self.json["bufferViews"][view as usize];
        let number = |name: &str| view[name].as_u64().map(|v| v as usize);
        let (Some(buffer), Some(length)) = (number("buffer"), number("byteLength")) else {
            return Ok(None);
        };
        let bytes: Option<Cow<[u8]>> = match self.json["buffers"][buffer]["uri"].as_str() {
            None => self.binary.as_deref().map(Cow::from),
            Some(uri) if uri.starts_with("data:") => from_data_uri(uri).map(Cow::from),
            Some(uri) => {
                let path = self.path.with_file_name("").join(&*percent_decoded(uri));
                Some(files::read(&path)?.into())
            }
        };
        let offset = number("byteOffset").unwrap_or(0);
        let range = offset..offset.saturating_add(length);
        Ok(bytes.and_then(|bytes| bytes.get(range).map(<[u8]>::to_vec)))
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

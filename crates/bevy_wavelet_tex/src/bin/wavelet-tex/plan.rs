//! What a run encodes and where it writes it, known before anything is encoded: an output has one image, an
//! image in several roles has what serves them all or an output for each, and no output is an original.

use std::{
    collections::HashMap,
    path::{Path, PathBuf},
};

use bevy_wavelet_tex::file::EXTENSION;

use crate::{
    Error,
    args::{AlphaArg, Role},
    files::{self, Destination, Input, Outputs},
    gltf::{self, Gltf, Use},
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
            let added = if files::has_extension(&input.path, gltf::EXTENSIONS) {
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
        let output = destination.of(input, EXTENSION)?;
        self.add(origin, &input.path, &input.relative, output, what)
    }

    fn add(
        &mut self,
        origin: Origin,
        label: &Path,
        relative: &Path,
        output: PathBuf,
        what: Option<Use>,
    ) -> Result<(), Error> {
        let key = files::identity(&output);
        if let Some(&index) = self.by_output.get(&key) {
            let image = &mut self.images[index];
            if image.origin == origin {
                image.uses.extend(what);
                return Ok(());
            }
            return Err(Error::file(
                label,
                format_args!(
                    "its result {} is that of {}: write them to different folders",
                    output.display(),
                    image.label.display()
                ),
            ));
        }
        self.by_output.insert(key, self.images.len());
        self.images.push(Image {
            origin,
            label: label.to_path_buf(),
            relative: relative.to_path_buf(),
            output,
            uses: what.into_iter().collect(),
        });
        Ok(())
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
                    let origin = Origin::Gltf {
                        file: input.path.clone(),
                        image: texture.image,
                    };
                    let label = format!("{} texture {}", input.path.display(), texture.index);
                    let label = Path::new(&label);
                    self.add(origin, label, &input.relative, output, Some(texture.what))
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
            let by_name = || {
                patterns
                    .role(&self.relative)
                    .map(|role| (role, RoleSource::Name))
            };
            let role = role
                .map(|role| (role, RoleSource::Argument))
                .or_else(by_name);
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

//! Expansion of files, folders and globs to input files, and the folders of their results.

use std::{
    collections::BTreeSet,
    path::{Component, Path, PathBuf},
};

use walkdir::WalkDir;

use crate::{
    error::Error,
    files::{self, has_extension},
};

/// A file and its path relative to the argument: its name, or its path below a folder.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Input {
    pub path: PathBuf,
    pub relative: PathBuf,
}

impl Input {
    fn single(path: &Path) -> Self {
        let name = path.file_name().unwrap_or(path.as_os_str());
        Self {
            path: path.to_path_buf(),
            relative: name.into(),
        }
    }
}

/// Returns whether the arguments can only name a single file.
pub fn is_single(named: &[PathBuf]) -> bool {
    matches!(named, [one] if !one.is_dir() && !is_pattern(one))
}

fn is_pattern(path: &Path) -> bool {
    let text = path.to_string_lossy();
    text.contains(['*', '?', '[']) && !path.exists()
}

/// Separates the output from the inputs where it is the second of two names and fits.
pub fn split_output<'a>(
    named: &'a [PathBuf],
    out: Option<&'a Path>,
    fits: impl Fn(&Path) -> bool,
) -> (&'a [PathBuf], Option<&'a Path>) {
    match (named, out) {
        ([_, last], None) if fits(last) => (&named[..1], Some(last)),
        _ => (named, out),
    }
}

/// Expands the arguments to files, each once and in order; from folders those with one of the
/// extensions. What cannot be expanded does not stop the rest.
pub fn expand(named: &[PathBuf], extensions: &[&str]) -> (Vec<Input>, Vec<Error>) {
    let mut expansion = Expansion {
        extensions,
        inputs: Vec::new(),
        errors: Vec::new(),
    };
    for path in named {
        let before = (expansion.inputs.len(), expansion.errors.len());
        let nothing = if path.is_dir() {
            expansion.folder(path, path);
            let all = extensions.join(" or .");
            format!("the folder has no .{all} file in it")
        } else if is_pattern(path) {
            expansion.glob(path);
            "no file fits".into()
        } else {
            expansion.inputs.push(Input::single(path));
            continue;
        };
        if (expansion.inputs.len(), expansion.errors.len()) == before {
            expansion.errors.push(Error::file(path, nothing));
        }
    }
    let mut seen = BTreeSet::new();
    expansion
        .inputs
        .retain(|input| seen.insert(input.path.clone()));
    (expansion.inputs, expansion.errors)
}

struct Expansion<'a> {
    extensions: &'a [&'a str],
    inputs: Vec<Input>,
    errors: Vec<Error>,
}

impl Expansion<'_> {
    /// Collects the files below a folder, with their paths below `root`. Links to folders are not followed,
    /// since they can form cycles.
    fn folder(&mut self, folder: &Path, root: &Path) {
        for entry in WalkDir::new(folder).sort_by_file_name() {
            match entry {
                Ok(entry) => {
                    let path = entry.into_path();
                    if has_extension(&path, self.extensions) && path.is_file() {
                        let relative = path.strip_prefix(root).unwrap_or(&path).to_path_buf();
                        self.inputs.push(Input { path, relative });
                    }
                }
                Err(error) => {
                    let path = error.path().unwrap_or(folder);
                    self.errors
                        .push(Error::file(path, format_args!("cannot be read: {error}")));
                }
            }
        }
    }

    /// Collects the files that a pattern fits, and those in the folders that it fits. The folders before its
    /// first wildcard are taken by their names, which can have brackets in them.
    fn glob(&mut self, path: &Path) {
        let mut root = PathBuf::new();
        let mut pattern = String::new();
        for component in path.components() {
            let next = root.join(component);
            if pattern.is_empty() && (next.exists() || !matches!(component, Component::Normal(_))) {
                root = next;
            } else {
                pattern.push('/');
                pattern.push_str(&component.as_os_str().to_string_lossy());
            }
        }
        let start = glob::Pattern::escape(&root.to_string_lossy());
        let pattern = match start.is_empty() {
            true => pattern[1..].into(),
            false => format!("{}{pattern}", start.trim_end_matches('/')),
        };
        let paths = match glob::glob(&pattern) {
            Ok(paths) => paths,
            Err(error) => {
                self.errors.push(Error::file(
                    path,
                    format_args!("not a valid glob: {}", error.msg),
                ));
                return;
            }
        };
        for matched in paths {
            match matched {
                Ok(path) if path.is_dir() => self.folder(&path, &root),
                Ok(path) => {
                    let relative = path.strip_prefix(&root).unwrap_or(&path).to_path_buf();
                    self.inputs.push(Input { path, relative });
                }
                Err(error) => self.errors.push(Error::file(
                    error.path(),
                    format_args!("cannot be read: {}", error.error()),
                )),
            }
        }
    }
}

/// The destination of the results.
pub enum Destination {
    /// Each result is written beside its input.
    Beside,
    /// The file of the only result.
    File(PathBuf),
    /// A folder for all results, which is created when needed.
    Folder(PathBuf),
}

impl Destination {
    /// Interprets `--out`.
    pub fn new(out: Option<&Path>, single: bool, extension: &str) -> Result<Self, Error> {
        let Some(out) = out else {
            return Ok(Self::Beside);
        };
        let is_file = single && has_extension(out, &[extension]);
        if is_file || single && !out.is_dir() && out.extension().is_some() {
            if !is_file {
                return Err(Error::Usage(format!(
                    "{}: the output's name must end in .{extension}",
                    out.display()
                )));
            }
            return Ok(Self::File(out.to_path_buf()));
        }
        if out.is_file() {
            return Err(Error::file(out, "a file, but a folder is needed"));
        }
        Ok(Self::Folder(out.to_path_buf()))
    }

    /// Path of the result of an input whose name it already has.
    pub fn named(&self, input: &Input) -> Result<PathBuf, Error> {
        match self {
            Self::Beside => Ok(input.path.clone()),
            Self::File(path) => Ok(path.clone()),
            Self::Folder(folder) => match files::without_parents(&input.relative) {
                Some(relative) => Ok(folder.join(relative)),
                None => Err(Error::file(
                    &input.path,
                    format_args!(
                        "its place is outside of the folder {}: encode a folder that both it and the glTF \
                         file are in",
                        folder.display()
                    ),
                )),
            },
        }
    }

    /// Path of the result of an input.
    pub fn of(&self, input: &Input, extension: &str) -> Result<PathBuf, Error> {
        match self {
            Self::File(path) => Ok(path.clone()),
            Self::Beside | Self::Folder(_) => Ok(self.named(input)?.with_extension(extension)),
        }
    }

    /// Whether folders of results are made.
    pub fn makes_folders(&self) -> bool {
        matches!(self, Self::Folder(_))
    }
}

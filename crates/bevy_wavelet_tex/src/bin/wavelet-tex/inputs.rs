//! Expansion of files, folders and globs to input files, and the paths of their results.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
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
/// extensions.
pub fn expand(named: &[PathBuf], extensions: &[&str]) -> Result<Vec<Input>, Error> {
    let mut inputs = Vec::new();
    for path in named {
        if path.is_dir() {
            let before = inputs.len();
            collect(path, extensions, &mut inputs)?;
            if inputs.len() == before {
                let wanted = extensions.join(" or .");
                return Err(Error::file(
                    path,
                    format_args!("the folder has no .{wanted} file in it"),
                ));
            }
        } else if is_pattern(path) {
            let pattern = path.to_string_lossy();
            let bad = |e: glob::PatternError| {
                Error::file(path, format_args!("not a valid glob: {}", e.msg))
            };
            let found: Vec<PathBuf> = glob::glob(&pattern)
                .map_err(bad)?
                .filter_map(Result::ok)
                .filter(|path| path.is_file())
                .collect();
            if found.is_empty() {
                return Err(Error::file(path, "no file fits"));
            }
            inputs.extend(found.iter().map(|path| Input::single(path)));
        } else {
            inputs.push(Input::single(path));
        }
    }
    let mut seen = std::collections::BTreeSet::new();
    inputs.retain(|input| seen.insert(input.path.clone()));
    Ok(inputs)
}

/// Collects the files below a folder. Links to folders are not followed, since they can form cycles.
fn collect(root: &Path, extensions: &[&str], inputs: &mut Vec<Input>) -> Result<(), Error> {
    for entry in WalkDir::new(root).sort_by_file_name() {
        let unreadable = |e| Error::file(root, format_args!("cannot be read: {e}"));
        let path = entry.map_err(unreadable)?.into_path();
        if path.is_file() && has_extension(&path, extensions) {
            let relative = path.strip_prefix(root).unwrap_or(&path).to_path_buf();
            inputs.push(Input { path, relative });
        }
    }
    Ok(())
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
            return Ok(Self::File(out.to_path_buf()));
        }
        if out.is_file() {
            return Err(Error::file(out, "a file, but a folder is needed"));
        }
        Ok(Self::Folder(out.to_path_buf()))
    }

    /// Path of a result whose name the input already has. Its folder is created.
    pub fn named(&self, input: &Input) -> Result<PathBuf, Error> {
        let path = match self {
            Self::Folder(folder) => folder.join(&input.relative),
            Self::Beside | Self::File(_) => input.path.clone(),
        };
        make_folder(&path)?;
        Ok(path)
    }

    /// Path of the result of an input. Its folder is created.
    pub fn of(&self, input: &Input, extension: &str) -> Result<PathBuf, Error> {
        let path = match self {
            Self::Beside => input.path.with_extension(extension),
            Self::File(path) => path.clone(),
            Self::Folder(folder) => {
                let path = folder.join(&input.relative).with_extension(extension);
                make_folder(&path)?;
                path
            }
        };
        files::check_output(&input.path, &path, extension)?;
        Ok(path)
    }
}

fn make_folder(path: &Path) -> Result<(), Error> {
    let folder = files::folder(path);
    let fail = |e| Error::file(&folder, format_args!("cannot be created: {e}"));
    fs::create_dir_all(&folder).map_err(fail)
}

/// Rejects a result whose path belongs to another input already.
#[derive(Default)]
pub struct Taken(BTreeMap<PathBuf, PathBuf>);

impl Taken {
    pub fn take(&mut self, output: &Path, input: &Path) -> Result<(), Error> {
        match self.0.insert(output.to_path_buf(), input.to_path_buf()) {
            None => Ok(()),
            Some(other) => Err(Error::file(
                input,
                format_args!(
                    "its result {} is that of {}: write them to different folders",
                    output.display(),
                    other.display()
                ),
            )),
        }
    }
}

//! The files of a run: expansion of files, folders and globs to input files, the paths of their results, reading of
//! whole files, and writing that never costs a file.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs::{self, OpenOptions},
    io::{self, Write},
    path::{Component, Path, PathBuf},
    time::SystemTime,
};

use bevy_wavelet_tex::{codec::image::WaveletImage, file};
use walkdir::WalkDir;

use crate::Error;

/// Reads a file, which must not be empty.
pub fn read(path: &Path) -> Result<Vec<u8>, Error> {
    let bytes =
        fs::read(path).map_err(|e| Error::file(path, format_args!("cannot be read: {e}")))?;
    if bytes.is_empty() {
        return Err(Error::file(path, "the file is empty"));
    }
    Ok(bytes)
}

pub fn read_texture(path: &Path) -> Result<WaveletImage, Error> {
    file::read(&read(path)?).map_err(|e| Error::file(path, e))
}

pub fn has_extension(path: &Path, extensions: &[&str]) -> bool {
    let is_one = |e: &std::ffi::OsStr| extensions.iter().any(|w| e.eq_ignore_ascii_case(w));
    path.extension().is_some_and(is_one)
}

/// The outputs of a run: which inputs they are of, and which files they may not be.
#[derive(Default)]
pub struct Outputs {
    originals: BTreeSet<PathBuf>,
    taken: BTreeMap<PathBuf, PathBuf>,
}

impl Outputs {
    /// Adds a file that no output may be.
    pub fn protect(&mut self, original: &Path) {
        self.originals.insert(identity(original));
    }

    /// Takes a path for the result of `input`. Call this once all originals are protected.
    pub fn take(&mut self, output: &Path, input: &Path) -> Result<(), Error> {
        let identity = identity(output);
        if self.originals.contains(&identity) {
            return Err(Error::file(
                output,
                "the output is the input, or another file that this run reads: name another file",
            ));
        }
        if let Some(other) = self.taken.get(&identity) {
            return Err(Error::file(
                input,
                format_args!(
                    "its result {} is that of {}: write them to different folders",
                    output.display(),
                    other.display()
                ),
            ));
        }
        self.taken.insert(identity, input.to_path_buf());
        Ok(())
    }
}

/// A path that all names of a file have in common: without links, `..` and, where names have no case, with
/// the case of the disk.
pub fn identity(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| {
        let folder = folder(path);
        let folder = folder.canonicalize().unwrap_or(folder);
        folder.join(path.file_name().unwrap_or_default())
    })
}

/// The path with its `..` resolved, or `None` where they lead out of it.
fn without_parents(path: &Path) -> Option<PathBuf> {
    let mut inside = PathBuf::new();
    for component in path.components() {
        match component {
            Component::Normal(name) => inside.push(name),
            Component::CurDir => {}
            Component::ParentDir if inside.pop() => {}
            _ => return None,
        }
    }
    Some(inside)
}

/// Rejects an output that could not be written, or that would cost a file, before the work is done. `is_own`
/// says whether a file was written by this tool.
pub fn check_output(
    output: &Path,
    makes_folders: bool,
    force: bool,
    is_own: fn(&[u8]) -> bool,
) -> Result<(), Error> {
    let refuse = |problem: String| Err(Error::file(output, problem));
    if output.is_dir() {
        return refuse("cannot be written: it is a directory".into());
    }
    let folder = folder(output);
    if makes_folders {
        let fail = |e| Error::file(&folder, format_args!("cannot be created: {e}"));
        fs::create_dir_all(&folder).map_err(fail)?;
    } else if !folder.is_dir() {
        return refuse(format!(
            "cannot be written: there is no folder {}: make it first",
            folder.display()
        ));
    }
    if force || !output.exists() {
        return Ok(());
    }
    let old = fs::read(output).unwrap_or_else(|_| vec![0]);
    if old.is_empty() || is_own(&old) {
        return Ok(());
    }
    refuse(
        "a file is there that wavelet-tex did not write: name another output, or overwrite it with --force"
            .into(),
    )
}

/// Writes to a temporary file beside `path` and renames it, so that the old file stays until the
/// new one is complete.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    let fail = |e: io::Error| Error::file(path, format_args!("cannot be written: {e}"));
    // A run that was killed may have left a file, and runs in several containers can have one process number.
    let (temporary, mut file) = loop {
        let now = SystemTime::UNIX_EPOCH.elapsed().unwrap_or_default();
        let name = format!(".wavelet-tex-{}-{}.tmp", std::process::id(), now.as_nanos());
        let temporary = folder(path).join(name);
        let opened = OpenOptions::new()
            .write(true)
            .create_new(true)
            .open(&temporary);
        match opened {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            opened => break (temporary, opened.map_err(fail)?),
        }
    };
    let written = file
        .write_all(bytes)
        .and_then(|()| file.sync_all())
        .and_then(|()| fs::rename(&temporary, path));
    drop(file);
    written.map_err(|e| {
        let _ = fs::remove_file(&temporary);
        fail(e)
    })
}

/// The folder that a file is in.
fn folder(path: &Path) -> PathBuf {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_path_buf(),
        _ => PathBuf::from("."),
    }
}

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
            Self::Folder(folder) => match without_parents(&input.relative) {
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

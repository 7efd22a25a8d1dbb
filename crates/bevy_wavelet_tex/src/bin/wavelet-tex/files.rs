//! Reading of whole files, and writing that never costs a file.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs::{self, OpenOptions},
    io::{self, Write},
    path::{Component, Path, PathBuf},
    time::SystemTime,
};

use bevy_wavelet_tex::{codec::image::WaveletImage, file};

use crate::error::Error;

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
pub fn without_parents(path: &Path) -> Option<PathBuf> {
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
pub fn folder(path: &Path) -> PathBuf {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_path_buf(),
        _ => PathBuf::from("."),
    }
}

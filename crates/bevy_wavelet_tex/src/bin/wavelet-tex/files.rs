//! Reading of whole files, and writing that keeps the old file when it fails.

use std::{
    fs::{self, OpenOptions},
    io::{self, Write},
    path::{Path, PathBuf},
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
    let is_wanted = |e: &std::ffi::OsStr| extensions.iter().any(|w| e.eq_ignore_ascii_case(w));
    path.extension().is_some_and(is_wanted)
}

/// Rejects an output that could not be written, before the work is done.
pub fn check_output(input: &Path, output: &Path, extension: &str) -> Result<(), Error> {
    let refuse = |problem: String| Err(Error::file(output, problem));
    // The output can be the input by another path or through a link.
    if let (Ok(a), Ok(b)) = (input.canonicalize(), output.canonicalize())
        && a == b
    {
        return refuse("the output is the input: name another file".into());
    }
    if !has_extension(output, &[extension]) {
        return Err(Error::Usage(format!(
            "{}: the output's name must end in .{extension}",
            output.display()
        )));
    }
    if output.is_dir() {
        return refuse("cannot be written: it is a directory".into());
    }
    let folder = folder(output);
    if !folder.is_dir() {
        return refuse(format!(
            "cannot be written: there is no folder {}: make it first",
            folder.display()
        ));
    }
    Ok(())
}

/// Writes to a temporary file beside `path` and renames it, so that the old file stays until the
/// new one is complete.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    let temporary = folder(path).join(format!(".wavelet-tex-{}.tmp", std::process::id()));
    let fail = |e: io::Error| Error::file(path, format_args!("cannot be written: {e}"));

    let mut file = OpenOptions::new()
        .write(true)
        .create_new(true)
        .open(&temporary)
        .map_err(fail)?;
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

//! The command `wavelet-tex encode`.

use std::path::Path;

use bevy_wavelet_tex::file;

use crate::{
    args::EncodeArgs,
    batch::{self, Report},
    encode_one::{Encoder, Row},
    error::Error,
    files, gltf, image_file,
    inputs::{self, Destination},
    names::Patterns,
    plan::Plan,
};

/// Encodes images and the images of glTF files, and says a line about each.
pub fn run(args: &EncodeArgs) -> Result<Report, Error> {
    args.check()?;
    let patterns = match &args.roles {
        Some(file) => Patterns::read(file)?,
        None => Patterns::default(),
    };
    let is_texture = |path: &Path| files::has_extension(path, &[file::EXTENSION]);
    let (named, out) = inputs::split_output(&args.inputs, args.out.as_deref(), is_texture);
    let single = inputs::is_single(named) && !files::has_extension(&named[0], gltf::EXTENSIONS);
    let destination = Destination::new(out, single, file::EXTENSION)?;
    let extensions = [image_file::EXTENSIONS, gltf::EXTENSIONS].concat();
    let (inputs, errors) = inputs::expand(named, &extensions);
    let plan = Plan::new(&inputs, errors, &destination, args.role, &patterns);
    if plan.tasks.is_empty() && plan.errors.is_empty() {
        let others = plan
            .left
            .iter()
            .filter(|(_, others)| !others.is_empty())
            .map(|(_, others)| format!(", but for {others}"));
        return Err(Error::file(
            &named[0],
            format_args!(
                "there is nothing to encode: no material has a map{}",
                others.collect::<String>()
            ),
        ));
    }
    let mut encoder = Encoder::new(args, destination.makes_folders());
    let (rows, result) = batch::run(
        &plan.tasks,
        plan.errors,
        |task| &task.label,
        |task, batch| {
            let row = encoder.encode(task, batch)?;
            if !args.json {
                batch.say(&row.text());
            }
            Ok(row)
        },
    );
    for (path, others) in &plan.left {
        match others.as_str() {
            "" => batch::warn(path, "no material has a map"),
            _ => batch::warn(path, &format!("the maps of {others} keep their own images")),
        }
    }
    let text = if args.json {
        serde_json::to_string_pretty(&rows).expect("plain data")
    } else {
        count(&rows)
    };
    Ok((text, result))
}

/// How many files were encoded, where there are several.
fn count(rows: &[Row]) -> String {
    let unchanged = rows.iter().filter(|row| row.is_unchanged()).count();
    match (rows.len() - unchanged, unchanged) {
        (0 | 1, 0) | (0, 1) => String::new(),
        (encoded, 0) => format!("{encoded} files encoded"),
        (encoded, unchanged) => format!("{encoded} files encoded, {unchanged} unchanged"),
    }
}

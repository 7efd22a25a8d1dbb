//! The command `wavelet-tex decode`.

use std::path::{Path, PathBuf};

use bevy_wavelet_tex::file;

use crate::{
    args::DecodeArgs,
    batch::{self, Report},
    error::Error,
    files::{self, Outputs},
    inputs::{self, Destination, Input},
    picture::{Picture, is_own_png},
};

/// Decodes one level of each texture to a PNG, and says a line about each.
pub fn run(args: &DecodeArgs) -> Result<Report, Error> {
    let is_other = |path: &Path| !files::has_extension(path, &[file::EXTENSION]);
    let (named, out) = inputs::split_output(&args.inputs, args.out.as_deref(), is_other);
    let destination = Destination::new(out, inputs::is_single(named), "png")?;
    let (inputs, mut errors) = inputs::expand(named, &[file::EXTENSION]);
    let mut outputs = Outputs::default();
    inputs.iter().for_each(|input| outputs.protect(&input.path));
    let mut tasks: Vec<(&Input, PathBuf)> = Vec::new();
    for input in &inputs {
        let output = destination.of(input, "png");
        match output.and_then(|o| outputs.take(&o, &input.path).map(|()| o)) {
            Ok(output) => tasks.push((input, output)),
            Err(error) => errors.push(error),
        }
    }
    let (lines, result) = batch::run(
        &tasks,
        errors,
        |(input, _)| &input.path,
        |(input, output), batch| {
            let texture = files::read_texture(&input.path)?;
            if args.level >= texture.levels {
                return Err(Error::file(
                    &input.path,
                    format_args!(
                        "there is no level {}: its levels are 0 to {}",
                        args.level,
                        texture.levels - 1
                    ),
                ));
            }
            files::check_output(output, destination.makes_folders(), args.force, is_own_png)?;
            let picture = Picture::from_texture(&texture, args.level);
            picture.write_png(output)?;
            let [width, height] = picture.size;
            batch.say(&format!("{}: {width} x {height} pixels", output.display()));
            Ok(())
        },
    );
    let text = match lines.len() {
        0 | 1 => String::new(),
        files => format!("{files} files decoded"),
    };
    Ok((text, result))
}

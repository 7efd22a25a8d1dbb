//! The command `wavelet-tex decode`.

use std::path::Path;

use bevy_wavelet_tex::file;

use crate::{
    args::DecodeArgs,
    batch::{self, Report},
    error::Error,
    files,
    inputs::{self, Destination, Taken},
    picture::Picture,
};

/// Decodes one level of each texture to a PNG, and returns a line about each.
pub fn run(args: &DecodeArgs) -> Result<Report, Error> {
    let is_other = |path: &Path| !files::has_extension(path, &[file::EXTENSION]);
    let (named, out) = inputs::split_output(&args.inputs, args.out.as_deref(), is_other);
    let destination = Destination::new(out, inputs::is_single(named), "png")?;
    let inputs = inputs::expand(named, &[file::EXTENSION])?;
    let mut taken = Taken::default();
    let (lines, result) = batch::run(&inputs, |input, _| {
        let output = destination.of(input, "png")?;
        taken.take(&output, &input.path)?;
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
        let picture = Picture::from_texture(&texture, args.level);
        picture.write_png(&output)?;
        let [width, height] = picture.size;
        Ok(format!("{}: {width} x {height} pixels", output.display()))
    });
    Ok((lines.join("\n"), result))
}

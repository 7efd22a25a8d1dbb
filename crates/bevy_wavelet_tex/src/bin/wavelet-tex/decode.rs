//! `wavelet-tex decode`.

use crate::{args::DecodeArgs, error::Error, files, picture::Picture};

/// Decodes one level to a PNG; one line about it.
pub fn run(args: &DecodeArgs) -> Result<String, Error> {
    files::check_output(&args.input, &args.output, "png")?;
    let texture = files::read_texture(&args.input)?;
    if args.level >= texture.levels {
        return Err(Error::file(
            &args.input,
            format_args!(
                "there is no level {}: its levels are 0 to {}",
                args.level,
                texture.levels - 1
            ),
        ));
    }
    let picture = Picture::from_texture(&texture, args.level);
    picture.write_png(&args.output)?;
    let [width, height] = picture.size;
    Ok(format!(
        "{}: {width} x {height} pixels",
        args.output.display()
    ))
}

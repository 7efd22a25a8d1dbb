//! The command `wavelet-tex encode`.

use std::path::{Path, PathBuf};

use bevy_wavelet_tex::file;
use serde::Serialize;

use crate::{
    args::EncodeArgs,
    batch,
    encode_one::{Row, encode_one},
    error::Error,
    gltf, image_file,
    inputs::{self, Destination, Input, Taken},
    materials::{EncodedMap, MaterialRow},
    picture::Picture,
    report::Report,
};

/// Encodes images and the images of glTF files, and returns a line about each.
pub fn run(args: &EncodeArgs) -> Result<Report, Error> {
    args.options.check()?;
    let (named, out) = split_output(&args.inputs, args.out.as_deref());
    let single = inputs::is_single(named) && !inputs::has_extension(&named[0], gltf::EXTENSIONS);
    let destination = Destination::new(out, single, file::EXTENSION)?;
    let inputs = inputs::expand(named, image_file::EXTENSIONS)?;
    let mut taken = Taken::default();
    let (rows, result) = batch::run(&inputs, |input, _| {
        if inputs::has_extension(&input.path, gltf::EXTENSIONS) {
            return gltf_images(input, args, &destination, &mut taken);
        }
        let output = destination.of(input, file::EXTENSION)?;
        taken.take(&output, &input.path)?;
        let picture = Picture::read(&input.path)?;
        let (row, _) = encode_one(&input.path, picture, None, args, output)?;
        Ok(vec![Line::Image(row)])
    });
    let rows: Vec<Line> = rows.into_iter().flatten().collect();
    let text = if args.json {
        serde_json::to_string_pretty(&rows).expect("plain data")
    } else {
        rows.iter().map(Line::text).collect::<Vec<_>>().join("\n")
    };
    Ok((text, result))
}

/// A line of the report.
#[derive(Serialize)]
#[serde(untagged)]
enum Line {
    Image(Row),
    Material(MaterialRow),
}

impl Line {
    fn text(&self) -> String {
        match self {
            Self::Image(row) => row.text(),
            Self::Material(row) => row.text(),
        }
    }
}

/// Separates the output from the inputs where it is named last.
fn split_output<'a>(
    named: &'a [PathBuf],
    out: Option<&'a Path>,
) -> (&'a [PathBuf], Option<&'a Path>) {
    match (named, out) {
        ([inputs @ .., last], None)
            if inputs.len() == 1 && inputs::has_extension(last, &[file::EXTENSION]) =>
        {
            (inputs, Some(last))
        }
        _ => (named, out),
    }
}

/// Encodes all images that the materials of a glTF file use, each by its role, and measures the materials.
fn gltf_images(
    input: &Input,
    args: &EncodeArgs,
    destination: &Destination,
    taken: &mut Taken,
) -> Result<Vec<Line>, Error> {
    let (images, materials) = gltf::read(&input.path)?;
    let (mut lines, mut maps) = (Vec::new(), Vec::new());
    for image in images {
        // `WaveletGltf` looks for this name.
        let name = |path: &Path| {
            // `with_extension` would replace the number of the texture.
            let mut name = path.as_os_str().to_os_string();
            name.push(format!(".Texture{}.{}", image.index, file::EXTENSION));
            PathBuf::from(name)
        };
        let named = Input {
            path: name(&input.path),
            relative: name(&input.relative),
        };
        let output = match &image.file {
            // An image with a file of its own keeps its name and is shared by all glTF files that
            // use it.
            Some(path) => {
                let own = Input {
                    path: path.clone(),
                    relative: input
                        .relative
                        .with_file_name(path.file_name().unwrap_or_default()),
                };
                destination.of(&own, file::EXTENSION)?
            }
            None => destination.named(&named)?,
        };
        let label = format!("{} texture {}", input.path.display(), image.index);
        taken.take(&output, Path::new(&label))?;
        let picture = Picture::from_bytes(
            image.file.as_deref().unwrap_or(Path::new(&label)),
            &image.bytes,
        )?;
        let path = Path::new(&label);
        let (row, map) = encode_one(path, picture, Some(image.role), args, output)?;
        lines.push(Line::Image(row));
        maps.push(EncodedMap {
            textures: image.textures,
            ..map
        });
    }
    let measured = materials.iter().filter_map(|m| MaterialRow::new(m, &maps));
    lines.extend(measured.map(Line::Material));
    Ok(lines)
}

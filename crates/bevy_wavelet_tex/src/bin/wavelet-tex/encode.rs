//! The command `wavelet-tex encode`.

use std::path::{Path, PathBuf};

use crate::{
    args::EncodeArgs,
    batch::{self, Report},
    encode_one::{Row, encode_one},
    error::Error,
    files,
    gltf::{self, GltfImage},
    image_file,
    inputs::{self, Destination, Input, Taken},
};
use bevy_wavelet_tex::file;

/// Encodes images and the images of glTF files, and returns a line about each.
pub fn run(args: &EncodeArgs) -> Result<Report, Error> {
    args.check()?;
    let is_texture = |path: &Path| files::has_extension(path, &[file::EXTENSION]);
    let (named, out) = inputs::split_output(&args.inputs, args.out.as_deref(), is_texture);
    let single = inputs::is_single(named) && !files::has_extension(&named[0], gltf::EXTENSIONS);
    let destination = Destination::new(out, single, file::EXTENSION)?;
    let inputs = inputs::expand(named, image_file::EXTENSIONS)?;
    let mut taken = Taken::default();
    let (rows, result) = batch::run(&inputs, |input, _| {
        if files::has_extension(&input.path, gltf::EXTENSIONS) {
            return gltf_images(input, args, &destination, &mut taken);
        }
        let output = destination.of(input, file::EXTENSION)?;
        taken.take(&output, &input.path)?;
        let picture = image_file::read(&input.path)?;
        Ok(vec![encode_one(&input.path, picture, None, args, output)?])
    });
    let rows: Vec<Row> = rows.into_iter().flatten().collect();
    let text = if args.json {
        serde_json::to_string_pretty(&rows).expect("plain data")
    } else {
        rows.iter().map(Row::text).collect::<Vec<_>>().join("\n")
    };
    Ok((text, result))
}

/// Encodes all images that the materials of a glTF file use, each by its role.
fn gltf_images(
    input: &Input,
    args: &EncodeArgs,
    destination: &Destination,
    taken: &mut Taken,
) -> Result<Vec<Row>, Error> {
    let encode = |image: GltfImage| {
        // `WaveletGltf` looks for this name.
        let name = |path: &Path| {
            // `with_extension` would replace the number of the texture.
            let mut name = path.as_os_str().to_os_string();
            name.push(format!(".Texture{}.{}", image.index, file::EXTENSION));
            PathBuf::from(name)
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
            None => destination.named(&Input {
                path: name(&input.path),
                relative: name(&input.relative),
            })?,
        };
        let label = format!("{} texture {}", input.path.display(), image.index);
        let label = Path::new(&label);
        taken.take(&output, label)?;
        let picture = image_file::decode(image.file.as_deref().unwrap_or(label), &image.bytes)?;
        encode_one(label, picture, Some(image.role), args, output)
    };
    gltf::read(&input.path)?.into_iter().map(encode).collect()
}

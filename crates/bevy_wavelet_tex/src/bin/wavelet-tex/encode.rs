//! The command `wavelet-tex encode`.

use std::{
    io::{self, Write},
    path::{Path, PathBuf},
    time::Instant,
};

use bevy_wavelet_tex::{
    codec::{
        encoder::encode,
        image::{ColorSpace, Content, WaveletImage},
        settings::EncodeSettings,
        source::Source,
    },
    file,
};
use serde::Serialize;

use crate::{
    args::{EncodeArgs, EncoderOptions, Role},
    batch,
    compare::Difference,
    error::Error,
    files, gltf, image_file,
    inputs::{self, Destination, Input, Taken},
    materials::{EncodedMap, MaterialRow},
    picture::Picture,
    report::Report,
    request::Request,
};

/// The result of one image.
#[derive(Serialize)]
struct Row {
    input: PathBuf,
    output: PathBuf,
    content: &'static str,
    /// The packing of luma, or the format and size of a plain texture.
    packing: String,
    size: [u32; 2],
    levels: u32,
    bpp: f64,
    bytes: usize,
    psnr_db: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    mean_angle_degrees: Option<f64>,
    encode_s: f64,
    #[serde(skip)]
    quality: String,
}

impl Row {
    fn text(&self) -> String {
        let [width, height] = self.size;
        format!(
            "{}: {width} x {height} pixels, {}, {:.2} bpp, {} bytes, {}, {:.2} s",
            self.output.display(),
            self.packing,
            self.bpp,
            self.bytes,
            self.quality,
            self.encode_s,
        )
    }
}

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

/// Encodes one image. The second part of the result has no textures yet.
fn encode_one(
    input: &Path,
    mut picture: Picture,
    role: Option<Role>,
    args: &EncodeArgs,
    output: PathBuf,
) -> Result<(Row, EncodedMap), Error> {
    let mut request = args.options.request(picture.is_gray(), role)?;
    // In a glTF file the role alone decides.
    request.linear |= role.is_none() && picture.color_space == Some(ColorSpace::Linear);
    if request.rate.content(false) == Content::Normal {
        picture.complete_normals();
    }
    if let Some(most) = args.options.max_size
        && picture.size.iter().any(|s| *s > most)
    {
        picture = picture.reduced(most, request.color_space());
    }
    let start = Instant::now();
    let texture = encoded(input, &picture, request, &args.options, !args.no_mips)?;
    let encode_s = start.elapsed().as_secs_f64();
    let bytes = match args.zstd {
        Some(level) => file::write_zstd(&texture, level),
        None => file::write(&texture),
    };
    files::write(&output, &bytes)?;
    let decoded = Picture::from_texture(&texture, 0);
    let difference = Difference::between(&picture, &decoded, false);
    if let Some(wanted) = request.min_psnr_db
        && difference.psnr_db < wanted
    {
        warn(
            input,
            &format!(
                "the largest rate reaches {:.2} dB, not {wanted}",
                difference.psnr_db
            ),
        );
    }
    let row = Row {
        input: input.to_path_buf(),
        output,
        content: texture.content.name(),
        packing: texture.storage_name(),
        size: texture.size,
        levels: texture.levels,
        bpp: texture.bits_per_pixel(),
        bytes: bytes.len(),
        psnr_db: difference.psnr_db,
        mean_angle_degrees: difference.angles.map(|angles| angles.mean_angle_degrees),
        encode_s,
        quality: difference.quality(),
    };
    let map = EncodedMap {
        textures: Vec::new(),
        content: texture.content,
        original: picture,
        decoded,
        bpp: texture.bits_per_pixel(),
    };
    Ok((row, map))
}

fn encoded(
    path: &Path,
    picture: &Picture,
    request: Request,
    options: &EncoderOptions,
    mips: bool,
) -> Result<WaveletImage, Error> {
    if !options.alpha && picture.is_transparent() {
        warn(
            path,
            "the image has transparent pixels; alpha is dropped (--alpha keeps it)",
        );
    }
    let settings = EncodeSettings {
        rate: request.rate,
        min_psnr_db: request.min_psnr_db,
        alpha: options.alpha,
        color_space: request.color_space(),
        mips,
        effort: options.effort.into(),
        method: options.method.into(),
        formats: options.formats.into(),
    };
    let bar = batch::bar("mip levels");
    let source = Source::new(picture.size, picture.source());
    let texture = encode(&source, &settings, &|_, parts| {
        bar.set_length(parts as u64);
        bar.inc(1);
    });
    bar.finish_and_clear();
    texture.map_err(|e| Error::file(path, e))
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

fn warn(path: &Path, problem: &str) {
    let _ = writeln!(io::stderr(), "warning: {}: {problem}", path.display());
}

//! The command `wavelet-tex normals`, which measures the angular error of normal maps as wavelet
//! textures, in BC5 and in BC1.

mod lighting;
mod map;

use std::fmt::Write;

use bevy_wavelet_tex::codec::{encoder::Method, image::Content};
use serde::Serialize;

use crate::{
    Report, angle::Angles, args::NormalsArgs, batch, error::Error, inputs, picture::Picture,
};
use map::{Format, NormalMap};

/// The result of one map in one format.
#[derive(Serialize)]
struct Row {
    map: String,
    format: &'static str,
    bpp: f64,
    #[serde(flatten)]
    angles: Angles,
}

/// Measures all maps in all formats.
pub fn run(args: &NormalsArgs) -> Result<Report, Error> {
    let inputs = inputs::expand(&args.inputs, &["png"])?;
    let mut rows = Vec::new();
    for (name, map) in [
        ("smooth", NormalMap::smooth()),
        ("rough", NormalMap::rough()),
    ] {
        rows.extend(of_map(name, &map).expect("generated maps are of a good size"));
    }
    let (given, result) = batch::run(&inputs, |input, _| {
        let picture = Picture::read_png(&input.path)?;
        if picture.content == Content::Gray {
            return Err(Error::file(&input.path, "a gray image, not a normal map"));
        }
        let name = input.relative.with_extension("").display().to_string();
        of_map(&name, &NormalMap::given(&picture)).map_err(|e| Error::file(&input.path, e))
    });
    rows.extend(given.into_iter().flatten());
    if let Some(path) = &args.picture {
        write_picture(path)?;
    }
    let text = if args.json {
        serde_json::to_string_pretty(&rows).expect("plain data")
    } else {
        markdown(&rows)
    };
    Ok((text, result))
}

fn of_map(
    name: &str,
    map: &NormalMap,
) -> Result<Vec<Row>, bevy_wavelet_tex::codec::encoder::EncodeError> {
    let row = |format: Format| {
        let (back, bpp) = map.through(format)?;
        Ok(Row {
            map: name.into(),
            format: format.name(),
            bpp,
            angles: Angles::between(map.normals.iter().copied().zip(back.normals)),
        })
    };
    Format::ALL.into_iter().map(row).collect()
}

fn write_picture(path: &std::path::Path) -> Result<(), Error> {
    let exact = NormalMap::smooth();
    let through = |format| exact.through(format).expect("a map of a good size").0;
    let [bc1, bc5, ours] = [Format::Bc1, Format::Bc5, Format::Wavelet(Method::Best)].map(through);
    let picture = lighting::picture(&[&exact, &bc1, &bc5, &ours]);
    picture
        .save_with_format(path, image::ImageFormat::Png)
        .map_err(|e| Error::file(path, format_args!("cannot be written: {e}")))
}

fn markdown(rows: &[Row]) -> String {
    let mut text = "Angles to the original, in degrees\n\n\
        | map | format | bpp | mean | 99 of 100 | largest |\n| --- | --- | --- | --- | --- | --- |"
        .to_string();
    for row in rows {
        let Angles {
            mean_angle_degrees,
            p99_angle_degrees,
            max_angle_degrees,
        } = row.angles;
        let _ = write!(
            text,
            "\n| {} | {} | {:.2} | {mean_angle_degrees:.3} | {p99_angle_degrees:.3} \
             | {max_angle_degrees:.2} |",
            row.map, row.format, row.bpp,
        );
    }
    text
}

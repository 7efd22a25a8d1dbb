//! The command `wavelet-tex bench`.

use std::time::Instant;

use bevy_wavelet_tex::codec::{
    encoder::{EncodeError, encode},
    image::Content,
    quality::psnr_db,
    rate::Rate,
    settings::EncodeSettings,
    source::Source,
};
use serde::Serialize;

use crate::{
    args::BenchArgs,
    batch::{self, Report},
    error::Error,
    image_file, inputs,
    picture::Picture,
};

/// The result of one image at one rate.
#[derive(Clone, Serialize)]
struct Row {
    /// Name of the file without its extension.
    image: String,
    rate: String,
    /// Bits per pixel of the largest level, including padding.
    bpp: f64,
    /// PSNR of the largest level in dB; infinite when identical, which JSON writes as null.
    psnr_db: f64,
    /// Time to encode in seconds, without reading and without mips.
    encode_s: f64,
    #[serde(skip)]
    megapixels: f64,
}

/// Measures every image at every rate.
pub fn run(args: &BenchArgs) -> Result<Report, Error> {
    let rates: Vec<Rate> = if args.rates.is_empty() {
        let pictures = |r: &Rate| r.content(false) != Content::Normal;
        Rate::ALL.into_iter().filter(pictures).collect()
    } else {
        args.rates.clone()
    };
    let (inputs, errors) = inputs::expand(&args.inputs, image_file::EXTENSIONS);
    let (images, result) = batch::run(
        &inputs,
        errors,
        |input| &input.path,
        |input, _| {
            let picture = image_file::read(&input.path)?;
            let name = input.relative.with_extension("").display().to_string();
            rows(&name, &picture, &rates, args).map_err(|e| Error::file(&input.path, e))
        },
    );
    let text = if args.json {
        serde_json::to_string_pretty(&images.concat()).expect("plain data")
    } else if images.is_empty() {
        String::new()
    } else {
        table(&images, &rates)
    };
    Ok((text, result))
}

/// Encodes one image at each of the rates, without mips.
fn rows(
    name: &str,
    picture: &Picture,
    rates: &[Rate],
    args: &BenchArgs,
) -> Result<Vec<Row>, EncodeError> {
    let source = Source::new(picture.size, picture.source());
    let row = |&rate: &Rate| {
        let settings = EncodeSettings {
            rate,
            mips: false,
            ..args.encoder.settings()
        };
        let start = Instant::now();
        let texture = encode(&source, &settings, &|_, _| {})?;
        Ok(Row {
            encode_s: start.elapsed().as_secs_f64(),
            image: name.into(),
            rate: rate.name().into(),
            bpp: texture.bits_per_pixel(),
            psnr_db: psnr_db(&source, &texture),
            megapixels: picture.pixels.len() as f64 / 1e6,
        })
    };
    rates.iter().map(row).collect()
}

/// Formats a table with a line for each image, a column for each rate, and the means.
fn table(images: &[Vec<Row>], rates: &[Rate]) -> String {
    let widest = images.iter().map(|rows| rows[0].image.chars().count());
    let width = widest.max().unwrap_or(0).max("Mpixel/s".len());
    let line = |name: &str, cell: &dyn Fn(usize) -> String| {
        let cells = rates.iter().enumerate().map(|(i, rate)| {
            let column = rate.name().len().max(7) + 2;
            format!("{:>column$}", cell(i))
        });
        format!("{name:width$}{}", cells.collect::<String>())
    };
    // An image without an error has an infinite PSNR, which is left out of the mean.
    let mean = |rate: usize, value: fn(&Row) -> f64| {
        let values = images.iter().map(|rows| value(&rows[rate]));
        let values: Vec<f64> = values.filter(|v| v.is_finite()).collect();
        values.iter().sum::<f64>() / values.len() as f64
    };
    let speed = |i| mean(i, |row| row.megapixels) / mean(i, |row| row.encode_s);
    let mut lines = vec![line("PSNR, dB", &|i| rates[i].name().into())];
    lines.extend(images.iter().map(|rows| {
        let cell = |i: usize| format!("{:.2}", rows[i].psnr_db);
        line(&rows[0].image, &cell)
    }));
    lines.push(line("mean", &|i| {
        format!("{:.3}", mean(i, |row| row.psnr_db))
    }));
    lines.push(line("bpp", &|i| format!("{:.3}", mean(i, |row| row.bpp))));
    lines.push(line("Mpixel/s", &|i| format!("{:.2}", speed(i))));
    lines.join("\n")
}

//! The command `wavelet-tex bench`.

use std::{collections::BTreeMap, time::Instant};

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
    args::BenchArgs, batch, error::Error, image_file, inputs, picture::Picture, report::Report,
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
    let inputs = inputs::expand(&args.inputs, image_file::EXTENSIONS)?;
    let (images, result) = batch::run(&inputs, |input, _| {
        let picture = Picture::read(&input.path)?;
        let name = input.relative.with_extension("").display().to_string();
        rows(&name, &picture, &rates, args).map_err(|e| Error::file(&input.path, e))
    });
    let rows = images.concat();
    let text = if args.json {
        serde_json::to_string_pretty(&rows).expect("plain data")
    } else {
        table(&rows)
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
fn table(rows: &[Row]) -> String {
    let mut rates: Vec<&str> = Vec::new();
    let mut images: BTreeMap<&str, Vec<(&str, f64)>> = BTreeMap::new();
    for row in rows {
        if !rates.contains(&row.rate.as_str()) {
            rates.push(&row.rate);
        }
        let cells = images.entry(&row.image).or_default();
        cells.push((&row.rate, row.psnr_db));
    }
    let widest = images.keys().map(|name| name.chars().count()).max();
    let width = widest.unwrap_or(0).max("Mpixel/s".len());
    let columns: Vec<usize> = rates.iter().map(|rate| rate.len().max(7) + 2).collect();
    let line = |name: &str, cells: Vec<String>| {
        let cells = cells.iter().zip(&columns);
        let cells: String = cells
            .map(|(cell, column)| format!("{cell:>column$}"))
            .collect();
        format!("{name:width$}{cells}")
    };
    let mut lines = vec![line(
        "PSNR, dB",
        rates.iter().map(|r| r.to_string()).collect(),
    )];
    for (name, found) in &images {
        let cell = |rate: &&str| {
            let cell = found.iter().find(|(r, _)| r == rate);
            cell.map_or(String::new(), |(_, psnr)| format!("{psnr:.2}"))
        };
        lines.push(line(name, rates.iter().map(cell).collect()));
    }
    let of = |rate: &str| {
        rows.iter()
            .filter(|row| row.rate == rate)
            .collect::<Vec<_>>()
    };
    // An image without an error has an infinite PSNR, which is left out of the mean.
    let mean = |rate: &&str, value: fn(&Row) -> f64| {
        let values = of(rate).into_iter().map(value);
        let values: Vec<f64> = values.filter(|v| v.is_finite()).collect();
        values.iter().sum::<f64>() / values.len() as f64
    };
    let means = |value: fn(&Row) -> f64, digits: usize| {
        let cell = |rate: &&str| format!("{:.digits$}", mean(rate, value));
        rates.iter().map(cell).collect::<Vec<_>>()
    };
    lines.push(line("mean", means(|row| row.psnr_db, 3)));
    lines.push(line("bpp", means(|row| row.bpp, 3)));
    let speed = |rate: &&str| {
        let rows = of(rate);
        let seconds: f64 = rows.iter().map(|row| row.encode_s).sum();
        let megapixels: f64 = rows.iter().map(|row| row.megapixels).sum();
        format!("{:.2}", megapixels / seconds)
    };
    lines.push(line("Mpixel/s", rates.iter().map(speed).collect()));
    lines.join("\n")
}

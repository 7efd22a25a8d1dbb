//! The commands that measure, `wavelet-tex compare` and `wavelet-tex bench`.

use std::{fmt::Write, time::Instant};

use bevy_wavelet_tex::codec::{
    angle::{Angles, unit, unit_of},
    color::ycocg_from_rgb,
    encoder::{EncodeError, encode},
    image::Content,
    quality::{psnr_db, psnr_of},
    rate::Rate,
    settings::EncodeSettings,
    source::Source,
};
use serde::Serialize;

use crate::{
    Error,
    args::{BenchArgs, CompareArgs},
    batch::{self, Report},
    files,
    picture::{self, Picture},
};

/// The error between two pictures of one size.
#[derive(Serialize)]
pub struct Difference {
    /// Whether luma was compared (Y of YCoCg, as in the thesis), because one of the pictures is
    /// gray.
    luma: bool,
    /// Mean squared error of the channels, in 8-bit units squared; of colour as far as alpha shows it, of normals as unit
    /// vectors.
    pub mse: f64,
    /// PSNR in dB; infinite when the pictures are identical, which JSON writes as null.
    pub psnr_db: f64,
    /// Largest error of a channel, in 8-bit units.
    max_error: f64,
    /// Angles between the normals, for normal maps only.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub angles: Option<Angles>,
}

/// Compares two files.
pub fn compare(args: &CompareArgs) -> Result<String, Error> {
    let a = picture::read_any(&args.a)?;
    let b = picture::read_any(&args.b)?;
    if a.size != b.size {
        let [width, height] = a.size;
        return Err(Error::file(
            &args.b,
            format_args!(
                "{} x {} pixels, but {} has {width} x {height}: only images of one size can be \
                 compared",
                b.size[0],
                b.size[1],
                args.a.display(),
            ),
        ));
    }
    let difference = Difference::between(&a, &b, args.normal);
    if args.json {
        return Ok(serde_json::to_string_pretty(&difference).expect("plain data"));
    }
    let mut text = format!(
        "mse {:.4}, {}, max error {} of 255",
        difference.mse,
        difference.quality(),
        difference.max_error,
    );
    if difference.luma {
        let gray = if a.is_gray() { &args.a } else { &args.b };
        let _ = write!(text, " (of luma: {} is gray)", gray.display());
    }
    Ok(text)
}

impl Difference {
    /// Compares pictures of one size. The angles are measured when one of them is a normal map, or
    /// when `normal` is set.
    pub fn between(a: &Picture, b: &Picture, normal: bool) -> Self {
        let luma = a.is_gray() != b.is_gray();
        let normal = !luma && (normal || [a, b].iter().any(|p| p.content == Content::Normal));
        let direction = |[r, g, b, alpha]: [f64; 4]| {
            let [x, y, z] = unit([r, g, b].map(|v| v / 127.5 - 1.0));
            let [x, y, z] = [x, y, z].map(|v| (v * 127.5 + 127.5).round());
            [x, y, z, alpha]
        };
        // Without an alpha channel pixels are opaque.
        let channels = if !normal && (a.has_alpha || b.has_alpha) {
            4
        } else {
            3
        };
        let (mut sum, mut max_error) = (0.0, 0.0_f64);
        let mut add = |error: f64| {
            sum += error * error;
            max_error = max_error.max(error.abs());
        };
        for (a, b) in (0..a.pixels.len()).map(|i| (a.at(i), b.at(i))) {
            if luma {
                add(luma_of(a) - luma_of(b));
                continue;
            }
            let [a, b] = [a, b].map(|pixel| if normal { direction(pixel) } else { pixel });
            // A colour counts as far as it is seen.
            let seen = a[3].max(b[3]) / 255.0;
            (0..3).for_each(|i| add(seen * (a[i] - b[i])));
            if channels == 4 {
                add(a[3] - b[3]);
            }
        }
        let values = if luma { 1 } else { channels } * a.pixels.len();
        let mse = sum / values as f64;
        let angles = normal.then(|| {
            let pairs = a.pixels.iter().zip(&b.pixels);
            Angles::between(pairs.map(|(a, b)| (unit_of(*a), unit_of(*b))))
        });
        Self {
            luma,
            mse,
            psnr_db: psnr_of(mse),
            max_error,
            angles,
        }
    }

    /// Formats the PSNR and, for normals, the mean angle.
    pub fn quality(&self) -> String {
        let psnr = if self.psnr_db.is_finite() {
            format!("{:.2} dB", self.psnr_db)
        } else {
            "identical".into()
        };
        self.angles.as_ref().map_or(psnr.clone(), |angles| {
            let mean = angles.mean_angle_degrees;
            format!("{psnr}, {mean:.2} degrees on average")
        })
    }
}

/// Y of YCoCg, in 8-bit units.
fn luma_of(pixel: [f64; 4]) -> f64 {
    let [r, g, b, _] = pixel.map(|v| v as f32);
    ycocg_from_rgb([r, g, b]).y.into()
}

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
pub fn bench(args: &BenchArgs) -> Result<Report, Error> {
    let rates: Vec<Rate> = if args.rates.is_empty() {
        let pictures = |r: &Rate| r.content(false) != Content::Normal;
        Rate::ALL.into_iter().filter(pictures).collect()
    } else {
        args.rates.clone()
    };
    let (inputs, errors) = files::expand(&args.inputs, picture::EXTENSIONS);
    let (images, result) = batch::run(
        &inputs,
        errors,
        |input| &input.path,
        |input, _| {
            let picture = picture::read(&input.path)?;
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

//! The command `wavelet-tex sizes`.

use std::{fmt::Write, time::Instant};

use bevy_wavelet_tex::{
    codec::{
        encoder::{EncodeError, encode},
        image::{Content, WaveletImage},
        rate::Rate,
        settings::{EncodeSettings, Formats},
        source::Source,
    },
    file,
};
use serde::Serialize;

use crate::{
    args::SizesArgs, batch, error::Error, files, image_file, inputs, picture::Picture,
    report::Report, request::Request,
};

/// Bytes on disk of one image, and the time to read them.
#[derive(Serialize)]
struct Row {
    image: String,
    /// Bytes of the input file.
    input: usize,
    wtex: usize,
    wtex_zstd: usize,
    /// A texture of 8 bpp at full size (BC7, or BC5 of normals; BC4 of gray) as KTX2 with Zstandard.
    bc_zstd: usize,
    /// Seconds to read the `.wtex` from main memory.
    read_s: f64,
    read_zstd_s: f64,
    #[serde(skip)]
    pixels: usize,
}

/// Measures the files that every image becomes.
pub fn run(args: &SizesArgs) -> Result<Report, Error> {
    args.options.check()?;
    let inputs = inputs::expand(&args.inputs, image_file::EXTENSIONS)?;
    let (rows, result) = batch::run(&inputs, |input, _| {
        let bytes = files::read(&input.path)?;
        let picture = Picture::from_bytes(&input.path, &bytes)?;
        let request = args.options.request(picture.is_gray(), None)?;
        let name = input.relative.with_extension("").display().to_string();
        row(name, bytes.len(), &picture, request, args).map_err(|e| Error::file(&input.path, e))
    });
    let text = if args.json {
        serde_json::to_string_pretty(&rows).expect("plain data")
    } else {
        table(&rows, args.zstd)
    };
    Ok((text, result))
}

fn row(
    image: String,
    input: usize,
    picture: &Picture,
    request: Request,
    args: &SizesArgs,
) -> Result<Row, EncodeError> {
    let source = Source::new(picture.size, picture.source());
    let settings = EncodeSettings {
        rate: request.rate,
        min_psnr_db: request.min_psnr_db,
        alpha: args.options.alpha,
        color_space: request.color_space(),
        mips: true,
        effort: args.options.effort.into(),
        method: args.options.method.into(),
        formats: args.options.formats.into(),
    };
    let texture = encode(&source, &settings, &|_, _| {})?;
    let plain = EncodeSettings {
        rate: match request.rate.content(false) {
            Content::Gray => Rate::Gray4,
            Content::Normal => Rate::Normal8,
            _ => Rate::Color8,
        },
        min_psnr_db: None,
        formats: Formats::Plain,
        ..settings
    };
    let plain = encode(&source, &plain, &|_, _| {})?;
    let (wtex, wtex_zstd) = both(&texture, args.zstd);
    Ok(Row {
        image,
        input,
        wtex: wtex.len(),
        wtex_zstd: wtex_zstd.len(),
        bc_zstd: file::write_zstd(&plain, args.zstd).len(),
        read_s: read_s(&wtex),
        read_zstd_s: read_s(&wtex_zstd),
        pixels: picture.pixels.len(),
    })
}

fn both(texture: &WaveletImage, level: i32) -> (Vec<u8>, Vec<u8>) {
    (file::write(texture), file::write_zstd(texture, level))
}

/// The shortest of five times.
fn read_s(bytes: &[u8]) -> f64 {
    let times = (0..5).map(|_| {
        let start = Instant::now();
        std::hint::black_box(file::read(bytes)).expect("its own file");
        start.elapsed().as_secs_f64()
    });
    times.fold(f64::INFINITY, f64::min)
}

/// Formats a line for each image and the means, in bytes, and the times in ms per megapixel.
fn table(rows: &[Row], level: i32) -> String {
    let widest = rows.iter().map(|row| row.image.chars().count()).max();
    let width = widest.unwrap_or(0).max("mean".len());
    let zstd = format!("wtex zstd {level}");
    let heads = [
        "input",
        "wtex",
        &zstd,
        "BC zstd",
        "read, ms/Mpixel",
        "zstd, ms/Mpixel",
    ];
    let heads: String = heads.map(|head| format!("{head:>17}")).concat();
    let mut text = format!("{:width$}{heads}", "bytes");
    let mut line = |name: &str, rows: &[Row]| {
        let mean = |value: fn(&Row) -> usize| {
            rows.iter().map(|row| value(row) as f64).sum::<f64>() / rows.len() as f64
        };
        let sizes = [
            mean(|r| r.input),
            mean(|r| r.wtex),
            mean(|r| r.wtex_zstd),
            mean(|r| r.bc_zstd),
        ];
        let pixels: f64 = rows.iter().map(|row| row.pixels as f64).sum();
        let time = |value: fn(&Row) -> f64| 1e9 * rows.iter().map(value).sum::<f64>() / pixels;
        let sizes = sizes.map(|size| format!("{size:>17.0}")).concat();
        let times = [time(|r| r.read_s), time(|r| r.read_zstd_s)];
        let times = times.map(|ms| format!("{ms:>17.2}")).concat();
        let _ = write!(text, "\n{name:width$}{sizes}{times}");
    };
    for row in rows {
        line(&row.image, std::slice::from_ref(row));
    }
    if rows.len() > 1 {
        line("mean", rows);
    }
    text
}

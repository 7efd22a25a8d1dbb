//! The study of `bevy_wavelet_tex`.
//!
//! Of every image, each effort of the encoder gives a row: the reference decoder against the
//! original in 8 bits, `cpu_ms` the time to encode. `bytes` are those of the largest level, without
//! mips, and `fetches` those of one nearest sample there. Rows `r8`, `rg8` and `rgba8` are the
//! original itself. The rows of the [`tunnel`] have times of frames.
//!
//! Normal maps are compared as X, Y and Z mapped to 0 to 255, so their FLIP is that of the map seen
//! as a picture.

mod peers;
pub mod summary;
pub mod tunnel;

use std::time::Instant;

use bevy_wavelet_tex::codec::{
    color::ycocg_from_rgb,
    decoder::decode,
    encoder::{EncodeError, EncodeSettings, encode_rgb8},
    image::{ColorSpace, Content, Packing, PlaneGroup, WaveletImage},
    quantizer::PlaneCoding,
    rate::Rate,
    search::Effort,
};
use image::{Rgb, RgbImage};
use indicatif::ProgressBar;

use super::{Study, TradeoffError, note, options::Plan};
use crate::{
    content,
    metrics::compare,
    record::{Measurement, Report},
};

/// The study.
pub const STUDY: Study = Study {
    name: PLUGIN,
    measure,
    summary: summary::summary,
};

const PLUGIN: &str = "wavelet_tex";

/// Seed of the procedural images.
const SEED: u64 = 7;

const EFFORTS: [(Effort, &str); 3] = [
    (Effort::Fast, "fast"),
    (Effort::Default, "default"),
    (Effort::Best, "best"),
];

const DEFAULT_EFFORT: &[(Effort, &str)] = &[EFFORTS[1]];

/// An image to encode.
struct Input {
    scene: String,
    image: RgbImage,
    content: Content,
    rates: Vec<Rate>,
    /// What the first rate is encoded with.
    efforts: &'static [(Effort, &'static str)],
}

fn measure(plan: &Plan, progress: &ProgressBar) -> Result<Report, TradeoffError> {
    progress.set_message("images");
    let photo = content::photo_like(plan.photo[0], plan.photo[1], SEED);
    let inputs = inputs(plan, &photo, progress)?;
    let rendered = plan.picture.map_or(0, |_| plan.rounds as usize);
    let rows: usize = inputs
        .iter()
        .map(|i| i.rates.len() + i.efforts.len() - 1)
        .sum();
    progress.set_length((rows + rendered) as u64);

    let mut report = Report::default();
    for input in &inputs {
        report.measurements.push(Measurement {
            scene: input.scene.clone(),
            ..original(&input.image, input.content)
        });
        if input.content == Content::Color {
            report.measurements.push(peers::bc1_row(input)?);
        }
        // The default effort of the other rates.
        for (i, &rate) in input.rates.iter().enumerate() {
            let efforts = if i == 0 {
                input.efforts
            } else {
                DEFAULT_EFFORT
            };
            for &(effort, name) in efforts {
                progress.set_message(format!("{}, {} {name}", input.scene, rate.name()));
                let row = encoded_row(input, rate, effort, name, plan.repetitions)?;
                report.measurements.push(row);
                progress.inc(1);
            }
        }
    }
    if let Some(picture) = plan.picture {
        let tile = content::bricks(plan.tile[0], plan.tile[1], SEED).color;
        let (adapter, rows) = tunnel::rows(&tile, &tunnel::FILTERS, picture, plan, progress)?;
        report.adapter = adapter;
        report.measurements.extend(rows);
    }
    Ok(report)
}

/// Every image in the contents that it is measured as.
fn inputs(
    plan: &Plan,
    photo: &RgbImage,
    progress: &ProgressBar,
) -> Result<Vec<Input>, TradeoffError> {
    let [width, height] = plan.tile;
    let bricks = content::bricks(width, height, SEED);
    let mut colors = vec![
        ("photo".into(), photo.clone()),
        ("bricks".into(), bricks.color),
        (
            "foliage".into(),
            content::foliage(width, height, SEED).color,
        ),
    ];
    let generated = colors.len();
    colors.extend(kodak(plan, &plan.kodak, progress)?);
    let mut inputs = Vec::new();
    for (i, (scene, image)) in colors.into_iter().enumerate() {
        let in_full = i < generated || plan.kodak_in_full;
        let efforts = if in_full { &EFFORTS } else { DEFAULT_EFFORT };
        if in_full {
            inputs.push(Input {
                scene: format!("{scene} gray"),
                image: gray(&image),
                content: Content::Gray,
                rates: Rate::of(Content::Gray).collect(),
                efforts,
            });
        }
        inputs.push(Input {
            scene,
            image,
            content: Content::Color,
            rates: Rate::of(Content::Color).collect(),
            efforts,
        });
    }
    inputs.push(Input {
        scene: "bricks normal".into(),
        image: bricks.normal,
        content: Content::Normal,
        rates: vec![Rate::Normal4],
        efforts: &EFFORTS,
    });
    Ok(inputs)
}

/// The photographs of the Kodak set, where they are.
pub(super) fn kodak(
    plan: &Plan,
    numbers: &[u32],
    progress: &ProgressBar,
) -> Result<Vec<(String, RgbImage)>, TradeoffError> {
    let folder = &plan.kodak_folder;
    if !folder.is_dir() {
        if !numbers.is_empty() {
            let text = format!(
                "skipped: the Kodak images, not found in {}",
                folder.display()
            );
            note(progress, &text);
        }
        return Ok(Vec::new());
    }
    let read = |number: &u32| {
        let name = format!("kodim{number:02}");
        let path = folder.join(&name).with_extension("png");
        match image::open(&path) {
            Ok(image) => Ok((name, image.into_rgb8())),
            Err(source) => Err(TradeoffError::Image { path, source }),
        }
    };
    numbers.iter().map(read).collect()
}

/// The luma of an image, in all three channels.
fn gray(image: &RgbImage) -> RgbImage {
    let mut gray = image.clone();
    for pixel in gray.pixels_mut() {
        let luma = ycocg_from_rgb(pixel.0.map(f32::from)).y;
        *pixel = Rgb([luma.round() as u8; 3]);
    }
    gray
}

/// The baseline: no error and one fetch, in the smallest uncompressed format that hardware has for
/// the content.
fn original(image: &RgbImage, content: Content) -> Measurement {
    let (format, bytes_per_pixel) = match content {
        Content::Gray => ("r8", 1),
        Content::Normal => ("rg8", 2),
        Content::Color | Content::ColorAlpha => ("rgba8", 4),
    };
    Measurement {
        plugin: PLUGIN.into(),
        setting: format.into(),
        reference: "itself".into(),
        mse: Some(0.0),
        flip: Some(0.0),
        max_error: Some(0.0),
        bytes: Some(bytes_per_pixel * u64::from(image.width()) * u64::from(image.height())),
        fetches: Some(1.0),
        ..Measurement::default()
    }
}

/// One image at one rate with one effort.
fn encoded_row(
    input: &Input,
    rate: Rate,
    effort: Effort,
    name: &str,
    repetitions: usize,
) -> Result<Measurement, TradeoffError> {
    let mut times = Vec::new();
    let encoded = loop {
        let start = Instant::now();
        let encoded = encoded(&input.image, rate, effort, false)?;
        times.push(start.elapsed().as_secs_f64() * 1e3);
        if times.len() >= repetitions {
            break encoded;
        }
    };
    let decoded = decode(&encoded, 0).to_rgba8(input.content);
    let (width, height) = input.image.dimensions();
    let decoded = RgbImage::from_fn(width, height, |x, y| {
        let [r, g, b, _] = decoded[(y * width + x) as usize];
        Rgb([r, g, b])
    });
    Ok(Measurement {
        plugin: PLUGIN.into(),
        scene: input.scene.clone(),
        setting: format!("{} {name}", rate.name()),
        reference: "original in 8 bits".into(),
        cpu_ms: median(times),
        bytes: Some(encoded.gpu_bytes() as u64),
        fetches: Some(fetches(&encoded)),
        ..Measurement::from(&compare(&input.image, &decoded)?)
    })
}

fn encoded(
    image: &RgbImage,
    rate: Rate,
    effort: Effort,
    mips: bool,
) -> Result<WaveletImage, EncodeError> {
    let pixels: Vec<[u8; 3]> = image.pixels().map(|p| p.0).collect();
    let settings = EncodeSettings {
        rate,
        color_space: ColorSpace::Srgb,
        mips,
        effort,
        ..EncodeSettings::default()
    };
    encode_rgb8(&pixels, image.dimensions().into(), &settings)
}

/// Fetches of one decoded pixel: of each wavelet plane one, and eight more where the neighbours' means
/// foretell details; one of chroma.
fn fetches(image: &WaveletImage) -> f64 {
    let of_group = |group: &PlaneGroup| {
        if group.packing == Packing::Bc1 {
            return 1.0;
        }
        let of_plane = |coding: &PlaneCoding| {
            let neighbours = if coding.predictor == 0.0 { 0.0 } else { 8.0 };
            group.textures.len() as f64 + neighbours
        };
        group.codings.iter().map(of_plane).sum()
    };
    image.groups.iter().map(of_group).sum()
}

/// Bytes that the fetches of one decoded pixel take in their blocks, without a cache: of chroma four
/// texels each, since it is interpolated.
fn fetched_bytes(image: &WaveletImage) -> f64 {
    let of_group = |group: &PlaneGroup| {
        let formats = group.packing.formats();
        let texel = |i: usize| formats[i].block_bytes() as f64 / 16.0;
        if group.packing == Packing::Bc1 {
            return 4.0 * texel(0);
        }
        let of_plane = |coding: &PlaneCoding| {
            let all: f64 = (0..formats.len()).map(texel).sum();
            // The neighbours' means are in the first texture.
            let neighbours = if coding.predictor == 0.0 { 0.0 } else { 8.0 };
            all + neighbours * texel(0)
        };
        group.codings.iter().map(of_plane).sum()
    };
    image.groups.iter().map(of_group).sum()
}

/// The middle value, the upper one of two.
fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

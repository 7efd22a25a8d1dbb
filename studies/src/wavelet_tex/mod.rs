//! The study of `bevy_wavelet_tex`.
//!
//! Of every image, each effort of the encoder gives a row: the reference decoder against the
//! original in 8 bits, `cpu_ms` the time to encode. `bytes` are those of the largest level, without
//! mips, and `fetches` those of one nearest sample there. Rows `r8`, `rg8` and `rgba8` are the
//! original itself. The rows of the [`tunnel`] have times of frames.
//!
//! Normal maps are compared as X, Y and Z mapped to 0 to 255, so their FLIP is that of the map seen
//! as a picture.

use std::{collections::HashMap, time::Instant};

use bevy_frugal_lab::{
    content::{self, encoded, wavelets},
    headless::median,
    metrics::{SizeMismatch, compare},
};
use bevy_wavelet_tex::codec::{
    blocks::{BlockFormat, BlockQuality, decode_blocks, encode_bc1},
    color::ycocg_from_rgb,
    decoder::decode,
    image::{ColorSpace, Content, PlaneGroup, WaveletImage},
    packing::Packing,
    quantizer::PlaneCoding,
    rate::Rate,
    settings::{Effort, EncodeSettings},
};
use image::{Rgb, Rgb32FImage, RgbImage, RgbaImage, buffer::ConvertBuffer};
use indicatif::ProgressBar;
use serde::{Deserialize, Serialize};

use self::tunnel::TunnelRow;
use crate::{
    plan::Plan,
    record::{PictureError, PictureRow, Report},
    run::{Study, TradeoffError, note},
    summary::{Choice, Need, Quantity, Source, Summary, means},
};

pub mod tunnel;

/// The study.
pub struct WaveletTex;

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Rows {
    pub images: Vec<PictureRow>,
    pub tunnel: Vec<TunnelRow>,
}

impl Study for WaveletTex {
    const NAME: &'static str = "wavelet_tex";
    type Rows = Rows;

    fn measure(plan: &Plan, progress: &ProgressBar) -> Result<Report<Rows>, TradeoffError> {
        progress.set_message("images");
        let photo = content::photo_like(plan.photo[0], plan.photo[1], SEED);
        let inputs = inputs(plan, &photo, progress)?;
        let rendered = plan.picture.map_or(0, |_| plan.rounds as usize);
        let rows: usize = inputs
            .iter()
            .map(|i| i.rates.len() + i.efforts.len() - 1)
            .sum();
        progress.set_length((rows + rendered) as u64);

        let mut report = Report::<Rows>::default();
        for input in &inputs {
            let rows = image_rows(input, plan, progress)?;
            report.rows.images.extend(rows);
        }
        if let Some(picture) = plan.picture {
            let tile = content::bricks(plan.tile[0], plan.tile[1], SEED).color;
            let (adapter, rows) = tunnel::rows(&tile, &tunnel::FILTERS, picture, plan, progress)?;
            report.adapter = adapter;
            report.rows.tunnel = rows;
        }
        Ok(report)
    }

    fn summary(rows: &Rows) -> Summary {
        summary(&rows.images)
    }
}

/// The rows of an image: the image itself, every rate, and BC1 of colour.
fn image_rows(
    input: &Input,
    plan: &Plan,
    progress: &ProgressBar,
) -> Result<Vec<PictureRow>, TradeoffError> {
    let mut rows = vec![original(input)];
    if input.content == Content::Color {
        rows.push(bc1_row(input)?);
    }
    for (i, &rate) in input.rates.iter().enumerate() {
        let efforts = if i == 0 {
            input.efforts
        } else {
            DEFAULT_EFFORT
        };
        for &(effort, name) in efforts {
            progress.set_message(format!("{}, {} {name}", input.scene, rate.name()));
            rows.push(encoded_row(input, rate, effort, name, plan.repetitions)?);
            progress.inc(1);
        }
    }
    Ok(rows)
}

const EFFORTS: [(Effort, &str); 3] = [
    (Effort::Fast, "fast"),
    (Effort::Default, "default"),
    (Effort::Best, "best"),
];

const DEFAULT_EFFORT: &[(Effort, &str)] = &[EFFORTS[1]];

const SEED: u64 = 7;

/// An image to encode.
struct Input {
    scene: String,
    image: RgbImage,
    content: Content,
    rates: Vec<Rate>,
    /// The efforts of the encoder for the first rate; the others have the default one.
    efforts: &'static [(Effort, &'static str)],
}

/// All images, each once for every content that it is encoded as.
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
    colors.extend(photographs(plan, &plan.kodak, progress)?);
    let mut inputs = Vec::new();
    for (i, (scene, image)) in colors.into_iter().enumerate() {
        let in_full = i < generated || plan.kodak_in_full;
        let efforts = if in_full { &EFFORTS } else { DEFAULT_EFFORT };
        if in_full {
            inputs.push(Input {
                scene: format!("{scene} gray"),
                image: gray(&image),
                content: Content::Gray,
                rates: wavelet_rates(Content::Gray).collect(),
                efforts,
            });
        }
        inputs.push(Input {
            scene,
            image,
            content: Content::Color,
            rates: wavelet_rates(Content::Color).collect(),
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

/// The luma of an image, in all three channels.
fn gray(image: &RgbImage) -> RgbImage {
    let mut gray = image.clone();
    for pixel in gray.pixels_mut() {
        let luma = ycocg_from_rgb(pixel.0.map(f32::from)).y;
        *pixel = Rgb([luma.round() as u8; 3]);
    }
    gray
}

/// The rates of a content that have a wavelet of their own; the others are those of plain textures.
fn wavelet_rates(content: Content) -> impl Iterator<Item = Rate> {
    Rate::of(content).filter(|rate| rate.wavelet() == *rate)
}

/// Names and pixels of the photographs with these numbers; none, with a note, where the folder is
/// missing.
fn photographs(
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
        let image = image::open(&path).map_err(TradeoffError::file(&path))?;
        Ok((name, image.into_rgb8()))
    };
    numbers.iter().map(read).collect()
}

const ORIGINAL: &str = "original in 8 bits";

/// The image itself: no error and one fetch, in the smallest uncompressed format that hardware has
/// for the content.
fn original(input: &Input) -> PictureRow {
    let (format, bytes_per_pixel) = match input.content {
        Content::Gray => ("r8", 1),
        Content::Normal => ("rg8", 2),
        Content::Color | Content::ColorAlpha => ("rgba8", 4),
    };
    let (width, height) = input.image.dimensions();
    PictureRow {
        scene: input.scene.clone(),
        setting: format.into(),
        reference: "itself".into(),
        bytes: Some(bytes_per_pixel * u64::from(width) * u64::from(height)),
        fetches: 1.0,
        ..PictureRow::default()
    }
}

fn encoded_row(
    input: &Input,
    rate: Rate,
    effort: Effort,
    name: &str,
    repetitions: usize,
) -> Result<PictureRow, TradeoffError> {
    let settings = EncodeSettings {
        mips: false,
        effort,
        ..wavelets(rate, ColorSpace::Srgb)
    };
    let mut times = Vec::new();
    let encoded = loop {
        let start = Instant::now();
        let encoded = encoded(&input.image, &settings)?;
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
    Ok(PictureRow {
        scene: input.scene.clone(),
        setting: format!("{} {name}", rate.name()),
        reference: ORIGINAL.into(),
        cpu_ms: median(&times),
        bytes: Some(encoded.gpu_bytes() as u64),
        fetches: fetches_and_bytes(&encoded, 1.0)[0],
        error: PictureError::from(compare(&input.image, &decoded)?),
    })
}

/// BC1 of a colour image.
fn bc1_row(input: &Input) -> Result<PictureRow, SizeMismatch> {
    let size = <[u32; 2]>::from(input.image.dimensions());
    let rgba: RgbaImage = input.image.convert();
    let texels: Vec<_> = rgba.pixels().map(|p| p.0).collect();
    let start = Instant::now();
    let blocks = encode_bc1(&texels, size, BlockQuality::High);
    let encode_ms = start.elapsed().as_secs_f64() * 1e3;
    let texels = decode_blocks(BlockFormat::Bc1, &blocks, size);
    let decoded = Rgb32FImage::from_fn(size[0], size[1], |x, y| {
        let [r, g, b, _] = texels[(y * size[0] + x) as usize];
        Rgb([r, g, b])
    });
    Ok(PictureRow {
        scene: input.scene.clone(),
        setting: BlockFormat::Bc1.name().into(),
        reference: ORIGINAL.into(),
        cpu_ms: Some(encode_ms),
        bytes: Some(blocks.len() as u64),
        fetches: 1.0,
        error: PictureError::from(compare(&input.image, &decoded.convert())?),
    })
}

/// Gathers that read the low band around up to 2 x 2 neighbouring pixels, from which their details are
/// predicted.
const GATHERS: f64 = 4.0;

/// Fetches of one or of 2 x 2 neighbouring pixels: for each pixel, one of each texture of a wavelet plane
/// (where the low band is gathered, only of that with the details), and one of chroma. And the bytes that they take in
/// their blocks, without a cache: of gathers, and of chroma, which is interpolated, four texels each.
pub(super) fn fetches_and_bytes(image: &WaveletImage, pixels: f64) -> [f64; 2] {
    let of_group = |group: &PlaneGroup| {
        let formats = group.packing.formats();
        let texel = |i: usize| formats[i].block_bytes() as f64 / 16.0;
        if group.packing == Packing::Bc1 {
            return vec![[pixels, pixels * 4.0 * texel(0)]];
        }
        let of_plane = |coding: &PlaneCoding| {
            if coding.predictor == 0.0 {
                let texels: f64 = (0..formats.len()).map(texel).sum();
                return [pixels * group.textures.len() as f64, pixels * texels];
            }
            let details = texel(formats.len() - 1);
            [
                GATHERS + pixels,
                GATHERS * 4.0 * texel(0) + pixels * details,
            ]
        };
        group.codings.iter().map(of_plane).collect()
    };
    let parts = image.groups().flat_map(of_group);
    parts.fold([0.0; 2], |[a, b], [fetches, bytes]| {
        [a + fetches, b + bytes]
    })
}

/// How many images the Kodak set has. Other figures are comparable with means of all of them only.
const KODAK: usize = 24;
/// The setting of the images themselves, which take four bytes a pixel.
const UNCOMPRESSED: &str = "rgba8";

/// The rates on photographs in colour with the default effort: the Kodak images, or the generated
/// one.
fn summary(rows: &[PictureRow]) -> Summary {
    let pixels: HashMap<_, _> = { rows.iter() }
        .filter(|row| row.setting == UNCOMPRESSED)
        .filter_map(|row| Some((row.scene.as_str(), row.bytes? as f64 / 4.0)))
        .collect();
    let is_kodak = |scene: &str| scene.starts_with("kodim");
    let kodak = pixels.keys().filter(|scene| is_kodak(scene)).count();
    let rows: Vec<_> = { rows.iter() }
        .filter(|row| pixels.contains_key(row.scene.as_str()))
        .filter(|row| is_kodak(&row.scene) || kodak == 0 && row.scene == "photo")
        .collect();
    let compared = rows.iter().filter(|row| row.reference == ORIGINAL);
    let quality = means(compared.map(|row| (&row.setting, row.error.psnr_db)));
    let bits = means(rows.iter().map(|row| {
        let bits = |bytes| Some(8.0 * bytes as f64 / pixels.get(row.scene.as_str())?);
        (&row.setting, row.bytes.and_then(bits))
    }));
    let measured = quality.iter().filter_map(|(name, psnr)| {
        let (rate, source) = match name.split_once(' ') {
            Some((rate, "default")) => (rate, Source::Ours),
            Some(_) => return None,
            None => (*name, Source::Baseline),
        };
        Some(Choice {
            name: rate.into(),
            error: *psnr,
            cost: *bits.get(name)?,
            source,
        })
    });
    let in_color = RATES.iter().filter(|(rate, ..)| rate.starts_with("color"));
    let published = in_color.map(|(_, bits, psnr)| Choice {
        name: format!("thesis {bits}"),
        error: *psnr,
        cost: *bits,
        source: Source::Published,
    });
    Summary {
        title: "bevy_wavelet_tex: quality of photographs against memory".into(),
        error: Quantity::more("mean PSNR", "dB", 1),
        cost: Quantity::less("memory", "bits per pixel", 2),
        choices: measured
            .chain(published.filter(|_| kodak == KODAK))
            .collect(),
        needs: vec![
            Need::LeastCost,
            Need::Cost(3.0),
            Need::Error(38.0),
            Need::LeastError,
        ],
    }
}

/// The thesis's Table 3.4: rates, their bits per pixel, and the mean PSNR in dB of the Kodak images.
const RATES: [(&str, f64, f64); 4] = [
    ("gray2", 2.0, 34.0),
    ("color2.25", 2.25, 32.6),
    ("color3", 3.0, 33.4),
    ("color5", 5.0, 39.3),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_are_ours_and_other_formats_baselines() {
        let row = |scene: &str, setting: &str, psnr_db, bytes| PictureRow {
            scene: scene.into(),
            setting: setting.into(),
            reference: ORIGINAL.into(),
            error: PictureError {
                psnr_db,
                ..PictureError::default()
            },
            bytes: Some(bytes),
            ..PictureRow::default()
        };
        let mut measurements = vec![
            row("photo", "rgba8", None, 400),
            row("photo", "color3 default", Some(20.0), 38),
        ];
        for i in 1..=KODAK {
            let kodim = format!("kodim{i:02}");
            measurements.extend([
                row(&kodim, "rgba8", None, 400),
                row(&kodim, "color3 fast", Some(33.0), 38),
                row(&kodim, "color3 default", Some(34.0), 38),
                row(&kodim, "bc1", Some(36.0), 50),
            ]);
        }
        let all = summary(&measurements);
        let choice = |name: &str| all.choices.iter().find(|c| c.name == name);
        let ours = choice("color3").expect("ours");
        assert_eq!((ours.error, ours.source), (34.0, Source::Ours));
        assert!((ours.cost - 3.04).abs() < 1e-9);
        assert_eq!(choice("bc1").map(|c| c.source), Some(Source::Baseline));
        assert_eq!(all.choices.len(), 2 + 3);
        // Of some of the images, nothing was published.
        let some = summary(&measurements[..6]);
        assert_eq!(some.choices.len(), 2);
        assert_eq!(summary(&measurements[..2]).choices[0].error, 20.0);
    }
}

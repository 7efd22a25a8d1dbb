//! The rows of encoded images, and what sampling them takes.

use std::time::Instant;

use bevy_wavelet_tex::codec::{
    blocks::{BlockFormat, BlockQuality, decode_blocks, encode_bc1},
    decoder::decode,
    encoder::{EncodeError, encode_rgb8},
    image::{ColorSpace, Content, PlaneGroup, WaveletImage},
    packing::Packing,
    quantizer::PlaneCoding,
    rate::Rate,
    settings::{Effort, EncodeSettings, Formats},
};
use image::{Rgb, Rgb32FImage, RgbImage, RgbaImage, buffer::ConvertBuffer};

use super::inputs::Input;
use crate::{record::Measurement, study::TradeoffError};
use bevy_frugal_lab::{
    headless::median,
    metrics::{SizeMismatch, compare},
};

pub(super) const ORIGINAL: &str = "original in 8 bits";

/// The image itself: no error and one fetch, in the smallest uncompressed format that hardware has
/// for the content.
pub(super) fn original(image: &RgbImage, content: Content) -> Measurement {
    let (format, bytes_per_pixel) = match content {
        Content::Gray => ("r8", 1),
        Content::Normal => ("rg8", 2),
        Content::Color | Content::ColorAlpha => ("rgba8", 4),
    };
    Measurement {
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

pub(super) fn encoded_row(
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
        scene: input.scene.clone(),
        setting: format!("{} {name}", rate.name()),
        reference: ORIGINAL.into(),
        cpu_ms: median(&times),
        bytes: Some(encoded.gpu_bytes() as u64),
        fetches: Some(fetches(&encoded, 1.0)),
        ..Measurement::from(&compare(&input.image, &decoded)?)
    })
}

/// BC1 of a colour image.
pub(super) fn bc1_row(input: &Input) -> Result<Measurement, SizeMismatch> {
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
    Ok(Measurement {
        scene: input.scene.clone(),
        setting: BlockFormat::Bc1.name().into(),
        reference: ORIGINAL.into(),
        cpu_ms: Some(encode_ms),
        bytes: Some(blocks.len() as u64),
        fetches: Some(1.0),
        ..Measurement::from(&compare(&input.image, &decoded.convert())?)
    })
}

pub(super) fn encoded(
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
        formats: Formats::Wavelet,
        ..EncodeSettings::default()
    };
    encode_rgb8(&pixels, image.dimensions().into(), &settings)
}

/// Gathers that read the low band around up to 2 x 2 neighbouring pixels, from which their details are
/// predicted.
const GATHERS: f64 = 4.0;

/// Fetches of one or of 2 x 2 neighbouring pixels: for each pixel, one of each texture of a wavelet plane
/// (where the low band is gathered, only of that with the details), and one of chroma.
pub(super) fn fetches(image: &WaveletImage, pixels: f64) -> f64 {
    let of_group = |group: &PlaneGroup| {
        if group.packing == Packing::Bc1 {
            return pixels;
        }
        let of_plane = |coding: &PlaneCoding| {
            if coding.predictor == 0.0 {
                pixels * group.textures.len() as f64
            } else {
                GATHERS + pixels
            }
        };
        group.codings.iter().map(of_plane).sum()
    };
    image.groups.iter().map(of_group).sum()
}

/// Bytes that these fetches take in their blocks, without a cache: of gathers, and of chroma, which is
/// interpolated, four texels each.
pub(super) fn fetched_bytes(image: &WaveletImage, pixels: f64) -> f64 {
    let of_group = |group: &PlaneGroup| {
        let formats = group.packing.formats();
        let texel = |i: usize| formats[i].block_bytes() as f64 / 16.0;
        if group.packing == Packing::Bc1 {
            return pixels * 4.0 * texel(0);
        }
        let of_plane = |coding: &PlaneCoding| {
            if coding.predictor == 0.0 {
                pixels * (0..formats.len()).map(texel).sum::<f64>()
            } else {
                GATHERS * 4.0 * texel(0) + pixels * texel(formats.len() - 1)
            }
        };
        group.codings.iter().map(of_plane).sum()
    };
    image.groups.iter().map(of_group).sum()
}

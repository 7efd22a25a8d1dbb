//! What games store textures in today, on the same images.

use std::time::Instant;

use bevy_wavelet_tex::codec::blocks::{
    BlockFormat, BlockQuality, Texel, decode_blocks, encode_bc1,
};
use image::{Rgb, RgbImage};

use super::{Input, PLUGIN};
use crate::{
    metrics::{SizeMismatch, compare},
    record::Measurement,
};

/// The image as BC1, by the best that its encoder does.
pub(super) fn bc1_row(input: &Input) -> Result<Measurement, SizeMismatch> {
    let (width, height) = input.image.dimensions();
    let size = [width, height];
    let texels: Vec<Texel> = input
        .image
        .pixels()
        .map(|p| [p[0], p[1], p[2], 255])
        .collect();
    let start = Instant::now();
    let blocks = encode_bc1(&texels, size, BlockQuality::High);
    let cpu_ms = Some(start.elapsed().as_secs_f64() * 1e3);
    let decoded = decode_blocks(BlockFormat::Bc1, &blocks, size);
    let decoded = RgbImage::from_fn(width, height, |x, y| {
        let [r, g, b, _] = decoded[(y * width + x) as usize];
        Rgb([r, g, b].map(|v| (v * 255.0).round() as u8))
    });
    Ok(Measurement {
        plugin: PLUGIN.into(),
        scene: input.scene.clone(),
        setting: "bc1".into(),
        reference: "original in 8 bits".into(),
        cpu_ms,
        bytes: Some(blocks.len() as u64),
        fetches: Some(1.0),
        ..Measurement::from(&compare(&input.image, &decoded)?)
    })
}

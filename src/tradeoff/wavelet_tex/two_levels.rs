//! Two levels of wavelets at 1.5 bpp (thesis section 3.5.4): the details of the first level in BC1,
//! its low band encoded as gray at 2 bpp. It is measured but not shipped, since a pixel would need
//! texels of two textures and their neighbours.

use std::time::Instant;

use bevy_wavelet_tex::codec::{
    blocks::{BlockFormat, DetailEncoder, Starts, decode_blocks},
    decoder::decode,
    encoder::encode,
    haar::{Coefficients, inverse_haar},
    image::ColorSpace,
    layout,
    plane::Plane,
    predict::predicted,
    quantizer::PlaneCoding,
    rate::Rate,
    settings::{EncodeSettings, Formats},
    source::{Pixels, Source},
    wavelet::CoefficientPlane,
};
use image::{Rgb, Rgb32FImage};

/// Good values for photographs; the search for the first level hardly deviates from these.
const RANGE: f32 = 0.5;
const GAMMA: f32 = 0.6;
const PREDICTOR: f32 = 0.165;

/// Encodes and decodes a gray picture. Returns the decoded picture, the bytes of its blocks and the
/// milliseconds that encoding took.
pub(super) fn through_two_levels(luma: &Rgb32FImage) -> (Rgb32FImage, usize, f64) {
    let size = [luma.width(), luma.height()];
    let plane = Plane {
        size,
        values: luma.pixels().map(|p| p.0[0]).collect(),
    };
    let start = Instant::now();
    let first = CoefficientPlane::new(&plane);
    let (low_band, second_bytes) = second_level(&first.low_band);
    let coding = PlaneCoding {
        range: RANGE,
        gamma: GAMMA,
        zero_point: PlaneCoding::ZERO_POINT_565,
        predictor: PREDICTOR,
        ..PlaneCoding::linear([0.0, 1.0])
    };
    let texture = layout::coefficient_size(size).map(|s| s.next_multiple_of(4));
    let [width, height] = first.low_band.size;
    let prediction = |x: u32, y: u32| predicted(&low_band, x, y, PREDICTOR);
    let encoder = DetailEncoder::new(&coding, Starts::Two);
    let columns = texture[0] / 4;
    let blocks: Vec<u8> = (0..columns * texture[1] / 4)
        .flat_map(|block| {
            let details = std::array::from_fn(|i| {
                let x = (block % columns * 4 + i as u32 % 4).min(width - 1);
                let y = (block / columns * 4 + i as u32 / 4).min(height - 1);
                let (wanted, prediction) = (first.details(x, y), prediction(x, y));
                std::array::from_fn(|c| wanted[c] - prediction[c])
            });
            encoder.block(&details).0
        })
        .collect();
    let encode_ms = start.elapsed().as_secs_f64() * 1e3;

    let texels = decode_blocks(BlockFormat::Bc1, &blocks, texture);
    let decoded = Rgb32FImage::from_fn(size[0], size[1], |x, y| {
        let (qx, qy) = (x / 2, y / 2);
        let [r, g, b, _] = texels[(qy * texture[0] + qx) as usize];
        let (left, prediction) = (coding.load_details([r, g, b]), prediction(qx, qy));
        let quad = inverse_haar(Coefficients {
            ll: 2.0 * low_band.clamped(qx, qy),
            details: std::array::from_fn(|c| left[c] + prediction[c]),
        });
        Rgb([quad[(y % 2 * 2 + x % 2) as usize]; 3])
    });
    (decoded, blocks.len() + second_bytes, encode_ms)
}

/// Encodes and decodes the low band as gray at 2 bpp. Returns it with the bytes of its blocks.
fn second_level(low_band: &Plane) -> (Plane, usize) {
    let words: Vec<u16> = low_band
        .values
        .iter()
        .map(|v| (v.clamp(0.0, 1.0) * 65535.0).round() as u16)
        .collect();
    let settings = EncodeSettings {
        rate: Rate::Gray2,
        mips: false,
        color_space: ColorSpace::Linear,
        formats: Formats::Wavelet,
        ..EncodeSettings::default()
    };
    let source = Source::new(low_band.size, Pixels::Gray16(&words));
    let image = encode(&source, &settings, &|_, _| {}).expect("a size that has been halved");
    let decoded = decode(&image, 0);
    let values = decoded.pixels.iter().map(|p| p[0]).collect();
    let low_band = Plane {
        size: low_band.size,
        values,
    };
    (low_band, image.gpu_bytes())
}

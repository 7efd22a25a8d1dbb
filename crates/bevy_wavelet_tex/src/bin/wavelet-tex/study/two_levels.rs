//! Two levels of wavelets at 1.5 bpp (thesis section 3.5.4): the details of the first level in BC1,
//! its low band encoded as gray at 2 bpp. It is measured but not shipped, since a pixel would need
//! texels of two textures and their neighbours.

use std::time::Instant;

use bevy_wavelet_tex::codec::{
    blocks::{BlockFormat, DetailEncoder, Starts, decode_blocks},
    decoder::decode,
    encoder::{EncodeSettings, encode},
    haar::{Coefficients, inverse_haar},
    image::ColorSpace,
    layout,
    plane::Plane,
    predict::predicted,
    quantizer::PlaneCoding,
    rate::Rate,
    source::{Pixels, Source},
    wavelet::CoefficientPlane,
};

use super::{Float3, Rgb, psnr};

/// Good values for photographs; the search for the first level hardly deviates from these.
const RANGE: f32 = 0.5;
const GAMMA: f32 = 0.6;
const PREDICTOR: f32 = 0.165;

/// Measures a picture. Returns bits per pixel, PSNR in dB and seconds.
pub fn measured(luma: &Float3) -> (f64, f64, f64) {
    let size = [luma.width(), luma.height()];
    let plane = Plane {
        size,
        values: luma.pixels().map(|p| p.0[0]).collect(),
    };
    let start = Instant::now();
    let first = CoefficientPlane::new(&plane);
    let (means, second_bytes) = second_level(&first.means);
    let coding = PlaneCoding {
        range: RANGE,
        gamma: GAMMA,
        centre: PlaneCoding::CENTRE_565,
        predictor: PREDICTOR,
        ..PlaneCoding::linear([0.0, 1.0])
    };
    let texture = layout::coefficient_size(size).map(|s| s.next_multiple_of(4));
    let [width, height] = first.means.size;
    let foretold = |x: u32, y: u32| predicted(&means, x, y, PREDICTOR);
    let encoder = DetailEncoder::new(&coding, Starts::Two);
    let columns = texture[0] / 4;
    let blocks: Vec<u8> = (0..columns * texture[1] / 4)
        .flat_map(|block| {
            let details = std::array::from_fn(|i| {
                let x = (block % columns * 4 + i as u32 % 4).min(width - 1);
                let y = (block / columns * 4 + i as u32 / 4).min(height - 1);
                let (wanted, foretold) = (first.details(x, y), foretold(x, y));
                std::array::from_fn(|c| wanted[c] - foretold[c])
            });
            encoder.block(&details).0
        })
        .collect();
    let encode_s = start.elapsed().as_secs_f64();

    let texels = decode_blocks(BlockFormat::Bc1, &blocks, texture);
    let decoded = Float3::from_fn(size[0], size[1], |x, y| {
        let (qx, qy) = (x / 2, y / 2);
        let [r, g, b, _] = texels[(qy * texture[0] + qx) as usize];
        let (left, foretold) = (coding.load_details([r, g, b]), foretold(qx, qy));
        let quad = inverse_haar(Coefficients {
            ll: 2.0 * means.clamped(qx, qy),
            details: std::array::from_fn(|c| left[c] + foretold[c]),
        });
        Rgb([quad[(y % 2 * 2 + x % 2) as usize]; 3])
    });
    let bits = 8.0 * (blocks.len() + second_bytes) as f64;
    let pixels = f64::from(size[0]) * f64::from(size[1]);
    (bits / pixels, psnr(luma, &decoded), encode_s)
}

/// Encodes and decodes the low band as gray at 2 bpp. Returns it with the bytes of its blocks.
fn second_level(means: &Plane) -> (Plane, usize) {
    let words: Vec<u16> = means
        .values
        .iter()
        .map(|v| (v.clamp(0.0, 1.0) * 65535.0).round() as u16)
        .collect();
    let settings = EncodeSettings {
        rate: Rate::Gray2,
        mips: false,
        color_space: ColorSpace::Linear,
        ..EncodeSettings::default()
    };
    let source = Source::new(means.size, Pixels::Gray16(&words));
    let image = encode(&source, &settings, &|_, _| {}).expect("a size that has been halved");
    let decoded = decode(&image, 0);
    let values = decoded.pixels.iter().map(|p| p[0]).collect();
    let means = Plane {
        size: means.size,
        values,
    };
    (means, image.gpu_bytes())
}

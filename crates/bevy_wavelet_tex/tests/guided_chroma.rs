//! What chroma that is interpolated along luma would gain.
//!
//! `WAVELET_TEX_IMAGES=FOLDER cargo test --release -p bevy_wavelet_tex --no-default-features --features cli --test
//! guided_chroma -- --ignored --nocapture` prints the table of the images in a folder.
#![cfg(feature = "encode")]

use std::path::Path;

use bevy_wavelet_tex::codec::{
    axes::ColorAxes,
    blocks::{BlockFormat, decode_blocks},
    chroma::interpolated,
    encoder::encode_rgb8,
    image::WaveletImage,
    plane::Plane,
    quality::{psnr_db, psnr_of},
    rate::Rate,
    settings::{EncodeSettings, Formats},
    source::{Pixels, Source},
    wavelet::assemble,
};

const RATES: [Rate; 4] = [Rate::Color2_25, Rate::Color3, Rate::Color3_25, Rate::Color5];

/// Added to the variance of luma by which slopes are divided, so that noise has none: a quarter of a step of 8
/// bits, squared.
const NOISE: f32 = 1e-6;

/// Luma, and chroma at its own size, as they are stored.
fn stored(image: &WaveletImage) -> (Plane, [Plane; 2]) {
    let group = &image.groups[0];
    let texture = group.texture_size(image.size);
    let texels: Vec<_> = (0..group.textures.len())
        .zip(group.packing.formats())
        .map(|(i, format)| decode_blocks(*format, image.level_blocks(0, i, 0, 0), texture))
        .collect();
    let luma = assemble(
        group.packing,
        &group.codings[0],
        &texels,
        texture,
        image.size,
    );
    let group = &image.groups[1];
    let texture = group.texture_size(image.size);
    let texels = decode_blocks(BlockFormat::Bc1, image.level_blocks(1, 0, 0, 0), texture);
    let chroma = [0, 1].map(|c: usize| {
        Plane::from_fn(group.plane_size(image.size, 0), |x, y| {
            let [r, g, b, _] = texels[(y * texture[0] + x) as usize];
            group.codings[c].load_low([0.5 * (r + b), g][c])
        })
    });
    (luma, chroma)
}

/// The mean of the pixels of each texel.
fn reduced(luma: &Plane, halvings: u32) -> Plane {
    (0..halvings).fold(luma.clone(), |plane, _| plane.halved())
}

/// The slope of chroma over luma in 3 x 3 texels.
fn slopes(chroma: &Plane, luma: &Plane) -> Plane {
    Plane::from_fn(chroma.size, |x, y| {
        let around = Plane::positions([3, 3]).map(|(i, j)| {
            let at = |plane: &Plane| plane.clamped((x + i).max(1) - 1, (y + j).max(1) - 1);
            (at(luma), at(chroma))
        });
        let around: Vec<(f32, f32)> = around.collect();
        let mean = |value: &dyn Fn(&(f32, f32)) -> f32| around.iter().map(value).sum::<f32>() / 9.0;
        let (l, c) = (mean(&|v| v.0), mean(&|v| v.1));
        let covariance = mean(&|v| (v.0 - l) * (v.1 - c));
        covariance / (mean(&|v| (v.0 - l).powi(2)) + NOISE)
    })
}

/// Mean squared error in 8-bit units with chroma along luma.
fn guided_mse(pixels: &[[u8; 3]], image: &WaveletImage) -> f64 {
    let (luma, chroma) = stored(image);
    let halvings = image.groups[1].subsampling;
    let small = reduced(&luma, halvings);
    let wide = |plane: &Plane| interpolated(plane, halvings, image.size);
    let between = wide(&small);
    let planes = chroma.map(|chroma| {
        let (slope, straight) = (wide(&slopes(&chroma, &small)), wide(&chroma));
        let mut guided = straight.clone();
        let steps = luma.values.iter().zip(&between.values).zip(&slope.values);
        for (value, ((luma, between), slope)) in guided.values.iter_mut().zip(steps) {
            *value += slope * (luma - between);
        }
        (straight, guided)
    });
    let rgb = image.axes.rgb;
    let dot = |a: [f32; 3], b: [f32; 3]| (0..3).map(|i| a[i] * b[i]).sum::<f32>();
    let mut sum = 0.0;
    for (i, pixel) in pixels.iter().enumerate() {
        let mut values = [luma.values[i], 0.0, 0.0];
        for (c, (straight, guided)) in planes.iter().enumerate() {
            values[1 + c] = guided.values[i];
            // The encoder corrects luma for the error of chroma, of which this is another one.
            let correction = -dot(rgb[0], rgb[1 + c]) / dot(rgb[0], rgb[0]);
            values[0] += correction * (guided.values[i] - straight.values[i]);
        }
        let decoded = ColorAxes { rgb }.rgb_of(values);
        for (wanted, value) in pixel.iter().zip(decoded) {
            let value = (value.clamp(0.0, 1.0) * 255.0).round();
            sum += f64::from(f32::from(*wanted) - value).powi(2);
        }
    }
    sum / (3 * pixels.len()) as f64
}

#[test]
#[ignore = "a measurement, which prints a table"]
fn table_of_a_folder() {
    let folder = std::env::var("WAVELET_TEX_IMAGES").unwrap_or_else(|_| {
        concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data/kodak").into()
    });
    let Ok(entries) = Path::new(&folder).read_dir() else {
        println!("skipped: {folder} is not there");
        return;
    };
    let mut paths: Vec<_> = entries.flatten().map(|entry| entry.path()).collect();
    paths.sort();
    let names = RATES.map(|rate| format!("{:>20}", rate.name())).concat();
    println!("dB, and dB more with chroma along luma{names}");
    let mut gains: [Vec<f64>; 4] = Default::default();
    for path in paths {
        let Ok(picture) = image::open(&path) else {
            println!("skipped: {}", path.display());
            continue;
        };
        let picture = picture.to_rgb8();
        let pixels: Vec<[u8; 3]> = picture.pixels().map(|p| p.0).collect();
        let size = picture.dimensions().into();
        let mut line = format!("{:38}", path.file_stem().unwrap_or_default().display());
        for (gains, rate) in gains.iter_mut().zip(RATES) {
            let with = |formats| {
                let settings = EncodeSettings {
                    rate,
                    mips: false,
                    formats,
                    ..EncodeSettings::default()
                };
                encode_rgb8(&pixels, size, &settings).expect("a good image")
            };
            let chosen = psnr_db(
                &Source::new(size, Pixels::Rgb8(&pixels)),
                &with(Formats::Any),
            );
            let guided = psnr_of(guided_mse(&pixels, &with(Formats::Wavelet)));
            let gain = if chosen < guided {
                guided - chosen
            } else {
                0.0
            };
            line += &format!("{chosen:>12.2}{gain:>8.2}");
            gains.push(gain);
        }
        println!("{line}");
    }
    let mean = gains.map(|gains| gains.iter().sum::<f64>() / gains.len() as f64);
    println!("mean gain {mean:.3?}");
    // The decision not to interpolate chroma along luma.
    assert!(mean.iter().all(|gain| *gain < 0.2), "{mean:?}");
}

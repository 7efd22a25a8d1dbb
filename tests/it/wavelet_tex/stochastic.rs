//! Stochastic filtering: its mean is the exact filter, and its noise with and without temporal
//! anti-aliasing.

use bevy::{anti_alias::taa::TemporalAntiAliasing, math::Vec2, prelude::*};
use bevy_frugal_lab::content;
use bevy_wavelet_tex::{
    WaveletExtension, WaveletFilter, WaveletStorage,
    codec::{
        image::{ColorSpace, WaveletImage},
        rate::Rate,
        settings::{EncodeSettings, Formats},
    },
};

use super::{
    scene::{encoded_with, gpu_with_all_planes},
    viewer::Viewer,
};

const TARGET: [u32; 2] = [64, 48];

/// Frames whose mean is compared.
const FRAMES: usize = 64;

fn image() -> WaveletImage {
    let settings = EncodeSettings {
        rate: Rate::Color3,
        color_space: ColorSpace::Srgb,
        formats: Formats::Wavelet,
        ..EncodeSettings::default()
    };
    encoded_with(&content::photo_like(256, 256, 5), &settings)
}

/// A picture of the viewer's as it is next, in one frame.
fn next(viewer: &mut Viewer) -> Vec<[f64; 3]> {
    let shown = viewer.app.capture_f32().expect("a picture");
    let pixels = shown.pixels.iter();
    pixels.map(|p| [p[0], p[1], p[2]].map(f64::from)).collect()
}

/// The texture with so many of its pixels for one of the target.
fn show(
    viewer: &mut Viewer,
    image: &WaveletImage,
    filter: WaveletFilter,
    pixels: [f32; 2],
) -> Vec<[f64; 3]> {
    let extension = WaveletExtension {
        filter,
        ..Default::default()
    };
    viewer.show(image, WaveletStorage::Blocks, extension, view(pixels));
    next(viewer)
}

fn psnr(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    let pairs = a.iter().flatten().zip(b.iter().flatten());
    let mean = pairs.map(|(a, b)| (a - b).powi(2)).sum::<f64>() / (3 * a.len()) as f64;
    -10.0 * mean.log10()
}

fn mean(pictures: &[Vec<[f64; 3]>]) -> Vec<[f64; 3]> {
    let mut sum = vec![[0.0; 3]; pictures[0].len()];
    for picture in pictures {
        for (sum, pixel) in sum.iter_mut().zip(picture) {
            (0..3).for_each(|c| sum[c] += pixel[c] / pictures.len() as f64);
        }
    }
    sum
}

/// Views by pixels of the texture for one of the target, in x and y.
const VIEWS: [(&str, [f32; 2]); 4] = [
    ("magnified", [0.4, 0.3]),
    ("minified", [2.7, 2.7]),
    ("grazing", [1.5, 6.0]),
    ("far", [2.5, 20.0]),
];

fn view(pixels: [f32; 2]) -> [Vec2; 2] {
    let extent = Vec2::from(pixels) * Vec2::new(TARGET[0] as f32, TARGET[1] as f32) / 256.0;
    [Vec2::new(0.013, 0.027), extent]
}

#[test]
fn the_mean_of_many_frames_is_the_exact_filter() {
    let Some(_gpu) = gpu_with_all_planes() else {
        return;
    };
    let image = image();
    let mut viewer = Viewer::new(TARGET);
    for (name, pixels) in VIEWS {
        let exact = show(&mut viewer, &image, WaveletFilter::Anisotropic, pixels);
        for filter in [WaveletFilter::Stochastic, WaveletFilter::StochasticQuad] {
            show(&mut viewer, &image, filter, pixels);
            let frames: Vec<_> = (0..FRAMES)
                .map(|_| {
                    viewer.app.render_frames(1).expect("a frame");
                    next(&mut viewer)
                })
                .collect();
            let one = psnr(&frames[0], &exact);
            let many = psnr(&mean(&frames), &exact);
            println!(
                "{name}, {filter:?}: one frame {one:.1} dB, the mean of {FRAMES} {many:.1} dB"
            );
            assert!(many > 40.0, "{name}, {filter:?}: {many} dB");
            // Independent frames would gain 18 dB, and the same frame again and again none.
            assert!(
                many > one + 10.0,
                "{name}, {filter:?}: {many} dB from {one} dB"
            );
        }
    }
}

/// Frames before the noise is measured: the history has forgotten how it began.
const WARM_UP: u32 = 48;

/// The noise of a filter: the mean square of what pixels of 16 frames differ from their mean, in dB
/// below white.
fn noise(
    viewer: &mut Viewer,
    image: &WaveletImage,
    filter: WaveletFilter,
    pixels: [f32; 2],
) -> f64 {
    show(viewer, image, filter, pixels);
    viewer.app.render_frames(WARM_UP).expect("frames");
    let frames: Vec<_> = (0..16)
        .map(|_| {
            viewer.app.render_frames(1).expect("a frame");
            next(viewer)
        })
        .collect();
    let mean = mean(&frames);
    let all: Vec<_> = frames.iter().flatten().copied().collect();
    psnr(&all, &mean.repeat(frames.len()))
}

#[test]
fn temporal_anti_aliasing_averages_the_noise() {
    let Some(_gpu) = gpu_with_all_planes() else {
        return;
    };
    let image = image();
    let mut plain = Viewer::new(TARGET);
    let mut smoothed = Viewer::new(TARGET);
    let world = smoothed.app.world_mut();
    let mut cameras = world.query_filtered::<Entity, With<Camera3d>>();
    let camera = cameras.single(world).expect("a camera");
    world
        .entity_mut(camera)
        .insert(TemporalAntiAliasing::default());
    for (name, pixels) in [VIEWS[0], VIEWS[1], VIEWS[2]] {
        let trilinear = noise(&mut smoothed, &image, WaveletFilter::Trilinear, pixels);
        for filter in [WaveletFilter::Stochastic, WaveletFilter::StochasticQuad] {
            let [without, with] =
                [&mut plain, &mut smoothed].map(|viewer| noise(viewer, &image, filter, pixels));
            println!(
                "{name}, {filter:?}: noise {without:.1} dB below white, with temporal \
                 anti-aliasing {with:.1} dB (trilinear {trilinear:.1} dB)"
            );
            assert!(with > without + 15.0, "{name}: {with} and {without} dB");
        }
    }
}

//! Stochastic filtering: its mean is the exact filter, and its noise with and without temporal
//! anti-aliasing.

use bevy::{anti_alias::taa::TemporalAntiAliasing, math::Vec2, prelude::*};
use bevy_frugal_lab::content;
use bevy_wavelet_tex::{
    WaveletFilter,
    codec::{
        image::{ColorSpace, WaveletImage},
        rate::Rate,
    },
};

use super::scene::{Viewer, colors, encoded_with, psnr_of_units as psnr, wavelets};

const TARGET: [u32; 2] = [64, 48];

/// Frames whose mean is compared.
const FRAMES: usize = 64;

fn image() -> WaveletImage {
    let settings = wavelets(Rate::Color3, ColorSpace::Srgb);
    encoded_with(&content::photo_like(256, 256, 5), &settings)
}

/// A picture of the viewer's as it is next, in one frame.
fn next(viewer: &mut Viewer) -> Vec<[f64; 3]> {
    colors(&viewer.app.capture_f32().expect("a picture"))
}

/// The texture with so many of its pixels for one of the target.
fn show(
    viewer: &mut Viewer,
    image: &WaveletImage,
    filter: WaveletFilter,
    pixels: [f32; 2],
) -> Vec<[f64; 3]> {
    viewer.show_blocks(image, filter, view(pixels));
    next(viewer)
}

/// The pictures of the next frames.
fn frames(viewer: &mut Viewer, count: usize) -> Vec<Vec<[f64; 3]>> {
    let picture = |_| {
        viewer.app.render_frames(1).expect("a frame");
        next(viewer)
    };
    (0..count).map(picture).collect()
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
    let Some(mut viewer) = Viewer::new(TARGET) else {
        return;
    };
    let image = image();
    for (name, pixels) in VIEWS {
        let exact = show(&mut viewer, &image, WaveletFilter::Anisotropic, pixels);
        for filter in [WaveletFilter::Stochastic, WaveletFilter::StochasticQuad] {
            show(&mut viewer, &image, filter, pixels);
            let frames = frames(&mut viewer, FRAMES);
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
    let frames = frames(viewer, 16);
    let mean = mean(&frames);
    let all: Vec<_> = frames.iter().flatten().copied().collect();
    psnr(&all, &mean.repeat(frames.len()))
}

#[test]
fn temporal_anti_aliasing_averages_the_noise() {
    let Some(mut viewer) = Viewer::new(TARGET) else {
        return;
    };
    let image = image();
    let filters = [WaveletFilter::Stochastic, WaveletFilter::StochasticQuad];
    let views = [VIEWS[0], VIEWS[1], VIEWS[2]];
    let noises = |viewer: &mut Viewer, filter| {
        views.map(|(_, pixels)| noise(viewer, &image, filter, pixels))
    };
    let without = filters.map(|filter| noises(&mut viewer, filter));
    let world = viewer.app.world_mut();
    let mut cameras = world.query_filtered::<Entity, With<Camera3d>>();
    let camera = cameras.single(world).expect("a camera");
    world
        .entity_mut(camera)
        .insert(TemporalAntiAliasing::default());
    let trilinear = noises(&mut viewer, WaveletFilter::Trilinear);
    for (filter, without) in filters.into_iter().zip(without) {
        let with = noises(&mut viewer, filter);
        for (i, (name, _)) in views.into_iter().enumerate() {
            let (without, with, trilinear) = (without[i], with[i], trilinear[i]);
            println!(
                "{name}, {filter:?}: noise {without:.1} dB below white, with temporal \
                 anti-aliasing {with:.1} dB (trilinear {trilinear:.1} dB)"
            );
            assert!(with > without + 15.0, "{name}: {with} and {without} dB");
        }
    }
}

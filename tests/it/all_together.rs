//! All four plugins in one scene: the 16 combinations of their switches.

use std::collections::BTreeMap;

use bevy::{
    camera::Exposure,
    prelude::*,
    time::{Time, Virtual},
};
use bevy_frugal_lab::{
    headless::HeadlessApp,
    runner::{MemoryFigures, Notes, Side, Split},
    scenes::all_together::{AllTogether, SWITCHES},
};
use image::RgbImage;

use crate::{scenes, support::drawn, wavelet_tex::gpu_with_all_planes};

const WIDTH: u32 = 112;
const HEIGHT: u32 = 64;
/// Edge in pixels of the blocks whose means are compared: what a plugin does to single texels is
/// its own tests' matter.
const BLOCK: u32 = 8;

/// The scene, without tone mapping and exposed so that nothing is clipped.
fn app() -> HeadlessApp {
    let set = ["tone_mapping=none", "sun_motion=false", "resolution=16"];
    let mut app = scenes::app(&AllTogether, [WIDTH, HEIGHT], &set);
    app.world_mut().insert_resource(Split { position: 0.0 });
    app.run_until_ready(1000).expect("ready");
    app.world_mut().resource_mut::<Time<Virtual>>().pause();
    // The sky of the picture is no plugin's matter, and clipped.
    let world = app.world_mut();
    world.insert_resource(ClearColor(Color::srgb(0.3, 0.3, 0.3)));
    let mut cameras = world.query_filtered::<&mut Exposure, With<Side>>();
    for mut exposure in cameras.iter_mut(world) {
        exposure.ev100 = 14.0;
    }
    app
}

/// The picture with those plugins whose bits are set, once the light has settled.
fn picture(app: &mut HeadlessApp, bits: usize) -> RgbImage {
    for (i, switch) in SWITCHES.iter().enumerate() {
        scenes::set(app, &format!("{switch}={}", bits >> i & 1 == 1));
    }
    // A change that no frame has seen yet would find the light settled.
    app.render_frames(2).expect("frames");
    app.run_until_ready(1000).expect("ready");
    app.run_until_ready(1000).expect("ready");
    app.capture_rgb8().expect("a picture")
}

/// Means of blocks in linear light, all channels.
fn blocks(picture: &RgbImage) -> Vec<f64> {
    let columns = WIDTH / BLOCK;
    let mut sums = vec![0.0; (3 * columns * (HEIGHT / BLOCK)) as usize];
    for (x, y, pixel) in picture.enumerate_pixels() {
        let block = y / BLOCK * columns + x / BLOCK;
        for (channel, level) in pixel.0.iter().enumerate() {
            let linear = Srgba::gamma_function(f32::from(*level) / 255.0);
            sums[3 * block as usize + channel] += f64::from(linear);
        }
    }
    sums.iter().map(|s| s / f64::from(BLOCK * BLOCK)).collect()
}

/// How much of the picture's brightness the effect of each plugin may change by whichever others are on; the page says
/// 0.35%. What the frame buffer does is rounding, and so is nearly all that the others change in it.
const INTERACTION: [f64; 4] = [0.0025, 0.0021, 0.0016, 0.0035];

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len() as f64;
    values.map(f64::abs).sum::<f64>() / count
}

/// Asserts that the memory figures and the state of the frame buffer are those of these plugins.
fn assert_figures(app: &HeadlessApp, bits: usize) {
    let on = |plugin: usize| bits >> plugin & 1 == 1;
    let figures = &app.world().resource::<MemoryFigures>().0;
    let figure = |name: &str| figures.get(name).copied().unwrap_or_default();
    let [before, after] = ["textures before", "textures after"].map(figure);
    if on(0) {
        assert!(after < before / 3, "{bits:04b}: {after} of {before} bytes");
    } else {
        assert_eq!(before, after, "{bits:04b}");
    }
    let notes = &app.world().resource::<Notes>().0;
    let is_packed = notes
        .get("frame buffer:")
        .is_some_and(|note| note == "packed");
    assert_eq!(on(1), is_packed, "{bits:04b}");
    assert_eq!(on(3), figure("volume after") > 0, "{bits:04b}");
}

#[test]
fn each_plugin_does_the_same_whichever_others_are_on() {
    let Some(_gpu) = gpu_with_all_planes() else {
        return;
    };
    let mut app = app();
    let mut drawn_pictures = BTreeMap::new();
    let mut picture = |bits: usize| -> (RgbImage, Vec<f64>) {
        let made = drawn_pictures.entry(bits).or_insert_with(|| {
            let picture = picture(&mut app, bits);
            assert_figures(&app, bits);
            let means = blocks(&picture);
            (picture, means)
        });
        made.clone()
    };
    let (none, means) = picture(0);
    let brightness = mean(means.iter().copied());
    assert!(
        brightness > 0.01,
        "a dark picture proves nothing: {brightness}"
    );
    let clipped = none.iter().filter(|level| **level == 255).count();
    assert_eq!(clipped, 0, "clipped levels hide effects");

    let pairs = (0..4).flat_map(|i| (1..16).map(move |others| (i, others)));
    let pairs = pairs.filter(|(i, others)| others >> i & 1 == 0);
    for (i, others) in drawn(1, pairs) {
        let plugin = SWITCHES[i];
        let mut effect = |others: usize| -> Vec<f64> {
            let (with, without) = (picture(others | 1 << i).1, picture(others).1);
            let pairs = with.iter().zip(&without);
            pairs.map(|(a, b)| a - b).collect()
        };
        let (alone, found) = (effect(0), effect(others));
        let size = mean(alone.iter().copied()) / brightness;
        println!("{plugin}: {:.2}% of the brightness", 100.0 * size);
        let changes = found.iter().zip(&alone).map(|(a, b)| a - b);
        let change = mean(changes) / brightness;
        let text = format!(
            "{plugin} beside {others:04b}: {:.2}% of the brightness else",
            100.0 * change
        );
        println!("{text}");
        assert!(change < INTERACTION[i], "{text}");
        assert_ne!(none, picture(1 << i).0, "{plugin} does nothing");
    }
    // The one that changes what is seen, rather than how: it must be seen.
    let light = picture(8).1;
    let light = light.iter().zip(&means).map(|(a, b)| a - b);
    assert!(mean(light) > 0.05 * brightness);
}

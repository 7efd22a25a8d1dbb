//! The scenes and the study of the compact frame buffer.

use bevy_frugal_lab::{
    metrics::error::max_error,
    scenes::ycocg_fb::scenes::{SCENES, TestScene},
    testing::gpu,
};

use crate::{
    record::PictureRow,
    ycocg_fb::{
        Frame,
        display::{ToneMap, display_frames, hdr_frame},
        scene_rows, settings,
    },
};

const SIZE: [u32; 2] = [160, 120];

fn scene(name: &str) -> &'static TestScene {
    let found = SCENES.iter().find(|scene| scene.name == name);
    found.expect("a scene of this name")
}

fn frame(name: &str) -> Frame {
    let image = hdr_frame(scene(name), SIZE).expect("a frame");
    Frame::from(&image)
}

fn luminance([r, g, b]: [f32; 3]) -> f32 {
    0.25 * r + 0.5 * g + 0.25 * b
}

/// Share of the pixels that differ from the one to the right by more than a tenth in a channel.
fn edges(frame: &Frame) -> f32 {
    let differs = |pair: &&[[f32; 3]]| {
        let [a, b] = [pair[0], pair[1]];
        (0..3).any(|c| (a[c] - b[c]).abs() > 0.1 * a[c].max(b[c]) + 1e-6)
    };
    frame.pixels.windows(2).filter(differs).count() as f32 / frame.pixels.len() as f32
}

#[test]
fn the_scenes_are_what_they_are_called() {
    let _gpu = gpu();
    let flat = frame("equal_luminance_edges");
    // Up to the rounding of the 16-bit target.
    let level = |p: &[f32; 3]| (luminance(*p) - 0.2).abs();
    assert!(flat.pixels.iter().map(level).fold(0.0, f32::max) < 2e-4);
    assert!(edges(&flat) > 0.01, "{}", edges(&flat));

    let hdr = frame("hdr_edge");
    let channels = || hdr.pixels.iter().flatten().copied();
    let largest = channels().fold(0.0, f32::max);
    assert!((9990.0..=10_010.0).contains(&largest), "{largest}");
    let black = hdr.pixels.iter().filter(|p| **p == [0.0; 3]).count();
    assert!(black > hdr.pixels.len() / 4, "{black} black pixels");

    let dark = frame("dark");
    let mean = dark.pixels.iter().map(|p| luminance(*p)).sum::<f32>() / dark.pixels.len() as f32;
    assert!((0.001..0.02).contains(&mean), "{mean}");

    let lit = frame("lit");
    let bright = lit.pixels.iter().filter(|p| luminance(**p) > 0.05).count();
    assert!(bright > lit.pixels.len() / 2, "{bright} lit pixels");

    // A line in nearly every row and column, and leaves everywhere.
    assert!(edges(&frame("thin_lines")) > 0.1);
    assert!(edges(&frame("foliage")) > 0.5);
}

#[test]
fn tone_mapping_on_the_cpu_is_that_of_the_camera() {
    let _gpu = gpu();
    let tone_map = ToneMap::capture().expect("a table");
    for name in ["lit", "hdr_edge"] {
        let (camera, _) = display_frames(scene(name), SIZE, &[]).expect("a picture");
        let ours = tone_map.display(&frame(name)).to_rgb8();
        let error = max_error(&camera, &ours).expect("one size");
        assert!(error <= 1, "{name}: {error} steps");
    }
}

#[test]
fn every_scene_is_measured_with_every_setting() {
    let _gpu = gpu();
    let tone_map = ToneMap::capture().expect("a table");
    let settings = settings();
    for scene in &SCENES {
        let rows = scene_rows(scene, SIZE, &settings, &tone_map).expect("rows");
        assert_eq!(rows.len(), 1 + settings.len());
        let mse = |setting: &str| mse(&rows, setting);
        assert_eq!(mse("rgba16float"), 0.0);
        // The goal on every scene: better than the thesis's filter, and that in 8 bits too.
        assert!(
            mse("default") < 0.75 * mse("edge_directed"),
            "{}",
            scene.name
        );
        assert!(
            mse("guided") < 0.75 * mse("edge_directed"),
            "{}",
            scene.name
        );
        assert!(mse("edge_directed") <= mse("bilinear"), "{}", scene.name);
        // Half the memory of the reference.
        let bytes = |setting: &str| find(&rows, setting).bytes;
        assert_eq!(bytes("default"), Some(160 * 120 * 4));
        assert_eq!(bytes("rgba16float"), Some(160 * 120 * 8));
    }
}

fn find<'a>(rows: &'a [PictureRow], setting: &str) -> &'a PictureRow {
    let found = rows.iter().find(|row| row.setting == setting);
    found.unwrap_or_else(|| panic!("no row {setting}"))
}

fn mse(rows: &[PictureRow], setting: &str) -> f64 {
    find(rows, setting).error.mse
}

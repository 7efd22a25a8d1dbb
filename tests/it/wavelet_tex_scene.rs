//! The example scene: its board of rates and the error view.

use bevy_frugal_lab::{
    runner::{Options, Outcome, pictures::picture_name, render_headless},
    scenes::wavelet_tex::WaveletTex,
};
use image::RgbImage;
use indicatif::ProgressBar;

use crate::wavelet_tex::gpu_with_all_planes;

/// The figures of a run, and its picture of "after".
fn run(name: &str, set: &[&str]) -> (Outcome, RgbImage) {
    let folder = std::env::temp_dir().join(format!("wavelet-scene-{name}-{}", std::process::id()));
    let options = Options::picture(160, 90, set);
    let outcome =
        render_headless(&WaveletTex, &options, &folder, &ProgressBar::hidden()).expect("a run");
    let picture = image::open(folder.join(picture_name("wavelet_tex", "after"))).expect("a PNG");
    let _ = std::fs::remove_dir_all(&folder);
    (outcome, picture.into_rgb8())
}

/// Parts of the picture that the panels fill, without their edges; left, top, width, height in pixels
/// of 160 x 90.
fn panels() -> [[u32; 4]; 8] {
    [0, 1, 2, 3, 4, 5, 6, 7].map(|i| [40 * (i % 4) + 4, 32 * (i / 4) + 18, 32, 18])
}

fn mean(picture: &RgbImage, [left, top, width, height]: [u32; 4]) -> f64 {
    let pixels = (top..top + height).flat_map(|y| (left..left + width).map(move |x| (x, y)));
    let sum: f64 = pixels
        .map(|(x, y)| picture.get_pixel(x, y).0.map(f64::from).iter().sum::<f64>())
        .sum();
    sum / f64::from(3 * width * height)
}

#[test]
fn the_board_has_every_rate_with_its_bytes_and_its_error() {
    let Some(_gpu) = gpu_with_all_planes() else {
        return;
    };
    let fast = ["place=rates", "effort=fast", "filter=bilinear", "zoom=4"];
    let (outcome, picture) = run("picture", &fast);
    assert!(outcome.psnr_db.is_some_and(|db| db > 30.0), "{outcome:?}");
    for panel in panels() {
        assert!(mean(&picture, panel) > 50.0, "{panel:?}");
    }
    let bytes = |name: &str| outcome.memory[&format!("{name} after")];
    assert_eq!(bytes("rgba8"), outcome.memory["rgba8 before"]);
    for (larger, smaller) in [
        ("rgba8", "color5"),
        ("color5", "color3.25"),
        ("color3.25", "color3"),
        ("color3", "color2.25"),
        ("color2.25", "gray2"),
        ("gray3", "gray2"),
    ] {
        assert!(bytes(larger) > bytes(smaller), "{larger} {smaller}");
    }
    assert_eq!(outcome.notes.len(), 7, "{:?}", outcome.notes);

    let mut set = fast.to_vec();
    set.extend(["view=error", "error_gain=32"]);
    let (_, error) = run("error", &set);
    // Nothing differs on the panel of the original, something on all others, least at 5 bits.
    let errors = panels().map(|panel| mean(&error, panel));
    assert_eq!(errors[0], 0.0);
    assert!(errors[1] > 0.0, "{errors:?}");
    assert!(errors[2..6].iter().all(|e| *e > errors[1]), "{errors:?}");
}

//! The study of elliptical filtering, at its smallest.

use bevy_frugal_lab::{lookups::scenes::SCENES, testing::gpu};
use indicatif::ProgressBar;

use crate::{
    ewa::{Ewa, SETTINGS},
    plan::Plan,
    run::Study,
};

const SCENE_NAMES: [&str; 7] = [
    "tunnel",
    "checker_1deg",
    "checker_5deg",
    "checker_5deg_45",
    "text",
    "srgb_stripes",
    "floor",
];
const SETTING_NAMES: [&str; 11] = [
    "reference",
    "linear",
    "bilinear",
    "approximate",
    "spatial",
    "temporal",
    "spatial_temporal",
    "stochastic",
    "software_af16",
    "hardware_af16",
    "trilinear",
];

#[test]
fn every_scene_has_every_setting_against_both_references() {
    let _gpu = gpu();
    assert_eq!(SCENES.map(|scene| scene.name), SCENE_NAMES);
    assert_eq!(SETTINGS.map(|setting| setting.name), SETTING_NAMES);
    let mut plan = Plan::new(true);
    plan.picture = Some([150, 100]);
    plan.rounds = 1;
    plan.frames = 2;
    let report = Ewa::measure(&plan, &ProgressBar::hidden()).expect("a report");
    let software = report.adapter.name.contains("llvmpipe");
    let rows = &report.rows;
    let find = |scene: &str, setting: &str, reference: &str| {
        let mut rows = rows.pictures.iter();
        rows.find(|row| row.scene == scene && row.setting == setting && row.reference == reference)
    };
    let row = |scene: &str, setting: &str, reference: &str| {
        find(scene, setting, reference)
            .unwrap_or_else(|| panic!("no row {scene}, {setting}, {reference}"))
    };
    for setting in SETTING_NAMES {
        if software && setting == "hardware_af16" {
            assert!(find("tunnel", setting, "truth").is_none(), "not hardware");
            continue;
        }
        for scene in SCENE_NAMES {
            for reference in ["truth", "ewa"] {
                let row = row(scene, setting, reference);
                let error = row.error;
                let figures = [error.mse, error.flip, error.max_error, row.fetches];
                let finite = |f: f64| f >= 0.0 && f.is_finite();
                assert!(figures.into_iter().all(finite), "{row:?}");
                assert!(error.psnr_db.is_none_or(|psnr| psnr > 10.0), "{row:?}");
            }
        }
        let mut times = rows.times.iter().filter(|row| row.scene == "tunnel");
        let time = times.find(|row| row.setting == setting).expect("a time");
        assert!(time.times.cpu_ms.is_some_and(|ms| ms > 0.0), "{time:?}");
    }
    let figure = |scene: &str, setting: &str| {
        let row = row(scene, setting, "ewa");
        (row.error.mse, row.fetches)
    };
    // The thesis's errors against EWA (table 5.1), on every scene.
    for scene in SCENE_NAMES {
        let [reference, linear, bilinear] =
            ["reference", "linear", "bilinear"].map(|setting| figure(scene, setting));
        assert!(reference.0 < 0.1 && linear.0 < 0.1, "{scene}: {linear:?}");
        assert!(bilinear.0 < 6.4, "{scene}: {bilinear:?}");
        assert!(linear.1 < 0.65 * reference.1, "{scene}: {linear:?} fetches");
        assert!(figure(scene, "approximate").0 < 30.0, "{scene}");
        for setting in ["spatial", "temporal", "spatial_temporal"] {
            let found = figure(scene, setting);
            println!("{scene} {setting}: {found:?}");
            assert!(found.0 < 55.0, "{scene} {setting}: {found:?}");
        }
    }
    // What a higher threshold saves costs accuracy.
    let curve = |threshold: u32| {
        let setting = format!("spatial, threshold {threshold}");
        figure("checker_5deg", &setting)
    };
    let [low, middle, high] = [4, 8, 16].map(curve);
    for lower in [low, middle] {
        assert!(lower.1 > high.1 && lower.0 < high.0, "{lower:?} {high:?}");
    }
    // Split over two frames, the picture of a still camera changes; with TAA it settles.
    let flicker_in = |scene: &str, setting: &str, camera: &str| {
        let mut rows = rows.flicker.iter().filter(|row| row.scene == scene);
        let row = rows.find(|row| row.setting == setting && row.camera == camera);
        row.unwrap_or_else(|| panic!("no row {scene}, {setting}, {camera}"))
            .mse
    };
    let flicker = |setting, camera| flicker_in("tunnel", setting, camera);
    let rasterised = |setting, camera| flicker_in("rasterised floor", setting, camera);
    assert_eq!(flicker("linear", "still"), 0.0);
    assert!(flicker("temporal", "still") > 4.0 * flicker("temporal", "still, TAA"));
    assert_eq!(rasterised("approximate", "still"), 0.0);
    let [without, with] = ["still", "still, Bevy's TAA"].map(|kind| rasterised("temporal", kind));
    println!("temporal, still: {without:.2}, with Bevy's TAA {with:.2}");
    assert!(without > 2.0 * with, "{without} {with}");
    // The methods differ under it, too: it does not switch them off.
    assert!(rasterised("trilinear", "moving, Bevy's TAA") > 0.5);
}

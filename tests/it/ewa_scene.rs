//! The example scene of elliptical filtering.

use bevy::time::{Time, Virtual};
use bevy_frugal_lab::{
    headless::HeadlessApp,
    metrics::error::mse,
    runner::{Scene, SettingKind},
    scenes::ewa::Ewa,
};
use image::RgbImage;

use crate::support::{
    gpu,
    scenes::{self, default_value, joined, picture, set, sides, values},
};

const SIZE: [u32; 2] = [128, 80];

fn app(size: [u32; 2], set: &[&str]) -> HeadlessApp {
    scenes::app(&Ewa, size, set)
}

fn difference(a: &RgbImage, b: &RgbImage) -> f64 {
    mse(a, b).expect("equal sizes")
}

/// The line is between two methods: each side is that method's own picture.
#[test]
fn tunnel_and_floor_have_a_method_on_each_side() {
    let _gpu = gpu();
    let mut app = app(SIZE, &["motion=false"]);
    for place in ["tunnel", "floor"] {
        set(&mut app, &format!("place={place}"));
        let [before, after] = sides(&mut app);
        let changed = difference(&before, &after);
        println!("{place}: {changed:.1}");
        assert!(changed > 3.0, "{place}: {changed}");
        // Neither empty nor flat.
        for picture in [&before, &after] {
            let lightest = picture.as_raw().iter().max();
            let darkest = picture.as_raw().iter().min();
            assert!(lightest > Some(&120) && darkest < Some(&60), "{place}");
        }
        let both = picture(&mut app, 0.5);
        let expected = joined([&before, &after], 64);
        assert!(difference(&both, &expected) < 1.0, "{place}");
        // The same method on both sides is the same picture.
        set(&mut app, "before=linear");
        assert!(difference(&picture(&mut app, 1.0), &after) < 0.01);
        set(&mut app, "before=hardware");
    }
}

#[test]
fn every_value_of_every_setting_changes_the_picture() {
    let _gpu = gpu();
    let mut app = app([64, 40], &["motion=false"]);
    // Methods that a setting is for.
    let needs = |name: &str| -> &[&str] {
        match name {
            "probes" | "max_anisotropy" => &["after=approximate"],
            "sigma" | "kernel" | "minor_radius" | "level_blend" | "max_fetches"
            | "level_of_detail" => &["after=reference"],
            "spatial_threshold" => &["after=spatial"],
            _ => &[],
        }
    };
    for setting in Ewa.settings() {
        let default = default_value(&setting);
        let count = match (&setting.kind, setting.name) {
            // llvmpipe's own anisotropic filter heeds no derivatives.
            (SettingKind::Toggle { .. }, _) | (_, "sampler_anisotropy") => 0,
            // Few pixels are more anisotropic than the default allows.
            (SettingKind::Integer { .. }, _) | (_, "max_anisotropy") => 1,
            _ => usize::MAX,
        };
        for text in needs(setting.name) {
            set(&mut app, text);
        }
        let position = if setting.name == "before" { 1.0 } else { 0.0 };
        let first = picture(&mut app, position);
        let values = values(&setting).into_iter().take(count);
        for value in values.filter(|value| *value != default) {
            set(&mut app, &format!("{}={value}", setting.name));
            let changed = difference(&first, &picture(&mut app, position));
            println!("{}={value}: {changed:.3}", setting.name);
            // Two texels a fetch are the same picture as one.
            let is_same = (setting.name, value.as_str()) == ("after", "reference");
            let is_right = if is_same {
                changed < 0.1
            } else {
                changed > 0.0
            };
            assert!(is_right, "{}={value}: {changed}", setting.name);
        }
        set(&mut app, &format!("{}={default}", setting.name));
        set(&mut app, "after=linear");
    }
}

#[test]
fn the_texture_drifts_when_it_should() {
    let _gpu = gpu();
    for (motion, moves) in [("motion=true", true), ("motion=false", false)] {
        let mut app = app(SIZE, &[motion]);
        let first = picture(&mut app, 0.0);
        app.world_mut().resource_mut::<Time<Virtual>>().unpause();
        app.render_frames(30).expect("frames");
        let changed = difference(&first, &picture(&mut app, 0.0));
        assert_eq!(changed > 5.0, moves, "{motion}: {changed}");
    }
}

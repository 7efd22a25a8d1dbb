//! Scenes of the lab with their settings and their split line: those of three plugins.

use bevy::prelude::*;
use bevy_frugal_lab::{
    headless::HeadlessApp,
    runner::{
        Options, Scene, SceneSetting, SceneSettings, SettingKind, Split, pictures::headless_app,
    },
};
use image::RgbImage;

pub fn app(scene: &'static dyn Scene, [width, height]: [u32; 2], set: &[&str]) -> HeadlessApp {
    headless_app(scene, &Options::picture(width, height, set)).expect("an app")
}

pub fn set(app: &mut HeadlessApp, text: &str) {
    let mut settings = app.world_mut().resource_mut::<SceneSettings>();
    settings.set(text).expect("a setting with this value");
}

/// The value of a setting that nobody sets.
pub fn default_value(setting: &SceneSetting) -> String {
    let settings = SceneSettings::new(vec![setting.clone()]);
    settings.iter().next().expect("a setting").1.to_string()
}

/// All values of a setting, or the least and the greatest.
pub fn values(setting: &SceneSetting) -> Vec<String> {
    match &setting.kind {
        SettingKind::Choice { names, .. } => names.iter().map(ToString::to_string).collect(),
        SettingKind::Toggle { .. } => vec!["true".into(), "false".into()],
        SettingKind::Integer { range, .. } => {
            vec![range.start().to_string(), range.end().to_string()]
        }
        SettingKind::Float { range, .. } => {
            vec![range.start().to_string(), range.end().to_string()]
        }
    }
}

/// The picture with the line at `position`. Time stands still from then on.
pub fn picture(app: &mut HeadlessApp, position: f32) -> RgbImage {
    app.world_mut().insert_resource(Split { position });
    // Frames are short while the processor traces paths beside them.
    app.run_until_ready(20_000).expect("ready");
    app.world_mut().resource_mut::<Time<Virtual>>().pause();
    app.capture_rgb8().expect("a picture")
}

/// What is before the line, and what is after it.
pub fn sides(app: &mut HeadlessApp) -> [RgbImage; 2] {
    [1.0, 0.0].map(|position| picture(app, position))
}

/// One picture up to column `line`, and the other from there on.
pub fn joined([before, after]: [&RgbImage; 2], line: u32) -> RgbImage {
    let (width, height) = before.dimensions();
    RgbImage::from_fn(width, height, |x, y| {
        *(if x < line { before } else { after }).get_pixel(x, y)
    })
}

mod ewa {
    //! The example scene of elliptical filtering.

    use bevy::time::{Time, Virtual};
    use bevy_frugal_lab::{
        headless::HeadlessApp,
        metrics::mse,
        runner::{Scene, SettingKind},
        scenes::ewa::Ewa,
    };
    use image::RgbImage;

    use super::{default_value, joined, picture, set, sides, values};
    use crate::support::gpu;

    const SIZE: [u32; 2] = [128, 80];

    fn app(size: [u32; 2], set: &[&str]) -> HeadlessApp {
        super::app(&Ewa, size, set)
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
    #[ignore = "long: a picture for each value"]
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
    #[ignore = "long: two apps in motion"]
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
}

mod wavelet_tex {
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
        let folder =
            std::env::temp_dir().join(format!("wavelet-scene-{name}-{}", std::process::id()));
        let options = Options::picture(160, 90, set);
        let outcome =
            render_headless(&WaveletTex, &options, &folder, &ProgressBar::hidden()).expect("a run");
        let picture =
            image::open(folder.join(picture_name("wavelet_tex", "after"))).expect("a PNG");
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
    #[ignore = "long: encodes seven textures"]
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
}

mod ycocg_fb {
    //! The example scene of the packed frame buffer.

    use bevy_frugal_lab::{
        headless::HeadlessApp,
        metrics::{
            heat_map::{absolute_error_heat_map, magma},
            max_error,
        },
        runner::{MemoryFigures, Notes, Scene, SplitLine},
        scenes::ycocg_fb::YCoCgFb,
    };
    use image::RgbImage;

    use super::{default_value, picture, set, sides, values};
    use crate::support::{gpu, psnr};

    const SIZE: [u32; 2] = [160, 120];

    fn app(size: [u32; 2], set: &[&str]) -> HeadlessApp {
        super::app(&YCoCgFb, size, set)
    }

    fn state(app: &HeadlessApp) -> &str {
        &app.world().resource::<Notes>().0["after:"]
    }

    /// Demands this PSNR in dB, of pictures that are not equal.
    fn assert_like(before: &RgbImage, after: &RgbImage, least_db: f64) {
        let psnr_db = psnr(before, after);
        assert!((least_db..100.0).contains(&psnr_db), "{psnr_db} dB");
    }

    #[test]
    fn after_looks_like_before() {
        let _gpu = gpu();
        let mut app = app(SIZE, &[]);
        let [before, after] = sides(&mut app);
        assert_eq!(state(&app), "packed");
        assert_like(&before, &after, 40.0);
        // A packed camera without `Hdr` is to look like one with it.
        set(&mut app, "hdr=false");
        let [fused_before, fused] = sides(&mut app);
        assert_eq!(fused_before, before);
        assert_eq!(state(&app), "packed");
        assert_like(&before, &fused, 39.0);
    }

    #[test]
    #[ignore = "long: a picture for each value"]
    fn every_value_of_every_setting_renders() {
        let _gpu = gpu();
        let mut app = app([64, 48], &[]);
        let first = picture(&mut app, 0.5);
        let mut pictures = vec![first.clone()];
        for setting in YCoCgFb.settings() {
            let values = values(&setting);
            assert!(values.len() > 1, "{}", setting.name);
            let default = default_value(&setting);
            for value in values {
                set(&mut app, &format!("{}={value}", setting.name));
                let picture = picture(&mut app, 0.5);
                let expected = match value.as_str() {
                    "rg11b10ufloat" => "drawn by Bevy in Rg11b10Ufloat",
                    _ => "packed",
                };
                assert_eq!(state(&app), expected, "{value}");
                pictures.push(picture);
            }
            set(&mut app, &format!("{}={default}", setting.name));
        }
        assert_eq!(picture(&mut app, 0.5), first, "all settings are back");
        pictures.sort_by(|a, b| a.as_raw().cmp(b.as_raw()));
        pictures.dedup();
        // Six scenes, the error, 4x, and the reconstructions at least.
        assert!(pictures.len() >= 12, "{} different", pictures.len());
    }

    #[test]
    fn unorm8_needs_a_camera_without_hdr() {
        let _gpu = gpu();
        let mut app = app(SIZE, &["format=unorm8", "hdr=true"]);
        let [before, after] = sides(&mut app);
        assert!(state(&app).contains("`Float16`"), "{}", state(&app));
        assert_eq!(before, after, "both are drawn by Bevy");
        set(&mut app, "hdr=false");
        let [before, after] = sides(&mut app);
        assert_eq!(state(&app), "packed");
        assert_like(&before, &after, 39.0);
    }

    #[test]
    fn memory_is_as_documented() {
        let _gpu = gpu();
        let mut app = app([64, 32], &[]);
        // Bytes a pixel: Bevy's own camera with `Hdr`, and the packed one.
        for (hdr, msaa, plain, packed) in [
            (true, "off", 16, 20),
            (true, "4x", 48, 36),
            (false, "off", 16, 12),
            (false, "4x", 48, 28),
        ] {
            set(&mut app, &format!("hdr={hdr}"));
            set(&mut app, &format!("msaa={msaa}"));
            picture(&mut app, 0.5);
            let figures = &app.world().resource::<MemoryFigures>().0;
            let of = |name: &str| figures[name] / (64 * 32);
            assert_eq!(of("total before"), plain, "{hdr} {msaa}");
            assert_eq!(of("total after"), packed, "{hdr} {msaa}");
            assert_eq!(of("packed after"), 4);
            assert_eq!(of("packed before"), 0);
            let multisampled = if msaa == "off" { 0 } else { 16 };
            assert_eq!(of("packed MSAA after"), multisampled);
        }
    }

    #[test]
    fn the_error_view_shows_the_error() {
        let _gpu = gpu();
        for scene in ["lit", "thin_lines"] {
            let mut app = app(SIZE, &["reconstruction=nearest", &format!("scene={scene}")]);
            let [before, after] = sides(&mut app);
            assert!(app.world().resource::<SplitLine>().0);
            set(&mut app, "view=error");
            let mut seen = Vec::new();
            for gain in [8, 32] {
                set(&mut app, &format!("error_gain={gain}"));
                let shown = picture(&mut app, 0.5);
                let expected = absolute_error_heat_map(&before, &after, gain as f32);
                let expected = expected.expect("equal sizes");
                // Its shader rounds once more than the CPU.
                let off = max_error(&shown, &expected).expect("equal sizes");
                assert!(off <= 2, "{scene}, gain {gain}: {off}");
                let black = shown.pixels().filter(|p| **p == magma(0.0)).count();
                assert!(black < shown.as_raw().len() / 3, "{scene}: no error");
                seen.push(shown);
            }
            assert_ne!(seen[0], seen[1]);
            assert!(!app.world().resource::<SplitLine>().0);

            set(&mut app, "view=picture");
            assert_eq!(sides(&mut app), [before, after], "{scene}");
        }
    }

    #[test]
    fn the_error_view_is_black_where_nothing_differs() {
        let _gpu = gpu();
        // Bevy draws both, as 8 bits hold no HDR.
        let mut app = app(
            SIZE,
            &["view=error", "format=unorm8", "hdr=true", "error_gain=32"],
        );
        let shown = picture(&mut app, 0.5);
        assert!(shown.pixels().all(|p| *p == magma(0.0)));
    }
}

//! The example scene of the packed frame buffer.

use bevy_frugal_lab::{
    headless::HeadlessApp,
    metrics::{
        error::max_error,
        heat_map::{absolute_error_heat_map, magma},
    },
    runner::{MemoryFigures, Notes, Scene, SplitLine},
    scenes::ycocg_fb::YCoCgFb,
};
use image::RgbImage;

use crate::support::{
    gpu, psnr,
    scenes::{self, default_value, picture, set, sides, values},
};

const SIZE: [u32; 2] = [160, 120];

fn app(size: [u32; 2], set: &[&str]) -> HeadlessApp {
    scenes::app(&YCoCgFb, size, set)
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

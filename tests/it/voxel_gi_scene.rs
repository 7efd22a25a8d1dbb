//! The example scene of the voxel GI.

use std::time::Duration;

use bevy::{
    prelude::*,
    time::{Time, Virtual},
};
use bevy_frugal_lab::{
    headless::HeadlessApp,
    runner::{MemoryFigures, Notes, Scene, SceneSettings},
    scenes::voxel_gi::VoxelGi,
};
use bevy_voxel_gi::VoxelGiVolume;
use image::RgbImage;

use crate::{
    scenes::{self, default_value, joined, picture, set, sides, values},
    support::gpu,
};

fn app(set: &[&str]) -> HeadlessApp {
    scenes::app(&VoxelGi, [128, 72], set)
}

/// The picture of "after" with this setting and a new volume: rays are others in each frame, and
/// so the same ones again.
fn anew(app: &mut HeadlessApp, text: &str) -> RgbImage {
    // A change of a setting that no frame has seen yet would bring the volume back.
    app.render_frames(1).expect("a frame");
    let world = app.world_mut();
    let mut volumes = world.query_filtered::<Entity, With<VoxelGiVolume>>();
    for volume in volumes.iter(world).collect::<Vec<_>>() {
        world.despawn(volume);
    }
    app.render_frames(3).expect("frames");
    set(app, text);
    picture(app, 0.0)
}

/// Mean absolute difference in levels of 255.
fn difference(a: &RgbImage, b: &RgbImage) -> f64 {
    let pairs = a.as_raw().iter().zip(b.as_raw());
    let sum: u64 = pairs.map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
    sum as f64 / a.as_raw().len() as f64
}

/// Share of the pixels that are black.
fn black(image: &RgbImage) -> f64 {
    let black = image.pixels().filter(|p| p.0.iter().all(|c| *c < 3));
    black.count() as f64 / f64::from(image.width() * image.height())
}

fn note<'a>(app: &'a HeadlessApp, name: &str) -> &'a str {
    let notes = &app.world().resource::<Notes>().0;
    notes.get(name).map_or("", String::as_str)
}

/// Lets the scene's time pass in one frame.
fn pass_time(app: &mut HeadlessApp, seconds: f32) {
    let mut time = app.world_mut().resource_mut::<Time<Virtual>>();
    time.set_max_delta(Duration::from_secs(100));
    time.set_relative_speed(60.0 * seconds);
    time.unpause();
    app.render_frames(1).expect("a frame");
    let mut time = app.world_mut().resource_mut::<Time<Virtual>>();
    time.set_relative_speed(1.0);
    time.pause();
}

#[test]
fn a_room_is_dark_before_and_lit_after() {
    let _gpu = gpu();
    let mut app = app(&["resolution=16"]);
    let [before, after] = sides(&mut app);
    assert!(black(&before) > 0.5, "{}", black(&before));
    assert!(black(&after) < 0.02, "{}", black(&after));
    // Tone mapping desaturates what is bright, so channels may fall, but not all together.
    let sum = |p: &image::Rgb<u8>| p.0.iter().map(|c| u32::from(*c)).sum::<u32>();
    let darker = before.pixels().zip(after.pixels());
    let darker = darker.filter(|(before, after)| sum(after) + 9 < sum(before));
    let darker = darker.count();
    assert!(
        darker < 40,
        "light takes nothing away: {darker} darker pixels"
    );
    // Lit, but not washed out: the mean is in the middle of the scale.
    let mean = after.as_raw().iter().map(|c| f64::from(*c)).sum::<f64>();
    let mean = mean / after.as_raw().len() as f64;
    assert!((70.0..190.0).contains(&mean), "{mean}");

    assert!(note(&app, "volume:").starts_with("settled"));
    let memory = &app.world().resource::<MemoryFigures>().0;
    assert!(memory["volume after"] > 100_000);
    assert_eq!(memory["volume before"], 0);

    // The split line is between the same pictures.
    let both = picture(&mut app, 0.5);
    let expected = joined([&before, &after], 64);
    assert!(difference(&both, &expected) < 1.0);
}

#[test]
#[ignore = "long: light for each value"]
fn every_value_of_every_setting_changes_the_picture() {
    let _gpu = gpu();
    let mut app = scenes::app(&VoxelGi, [64, 36], &["resolution=8", "rays=8"]);
    let first = anew(&mut app, "resolution=8");
    let noise = difference(&first, &anew(&mut app, "resolution=8"));
    println!("noise: {noise}");
    assert!(noise < 0.3, "{noise}");
    for setting in VoxelGi.settings() {
        let default = match setting.name {
            "resolution" | "rays" => "8".into(),
            _ => default_value(&setting),
        };
        let values = match setting.name {
            "rays" => vec!["4".into()],
            "iterations" => vec!["8".into()],
            _ => values(&setting),
        };
        let text = format!("{}={}", setting.name, values[0]);
        let mut alone = SceneSettings::new(vec![setting.clone()]);
        assert!(alone.set(&text).is_ok(), "{text}");
        for value in values.iter().filter(|value| **value != default) {
            // The Cornell box has a test of its own; large volumes take long without a GPU.
            // Others show with time, or are what they are compared with.
            if ["cornell", "64", "128"].contains(&value.as_str())
                || ["sun_motion", "iterations", "paths"].contains(&setting.name)
                || value == "closed"
            {
                continue;
            }
            let picture = anew(&mut app, &format!("{}={value}", setting.name));
            let changed = difference(&first, &picture);
            println!("{}={value}: {changed}", setting.name);
            assert!(changed > 2.0 * noise + 0.05, "{}={value}", setting.name);
            assert!(!note(&app, "volume:").is_empty());
        }
        set(&mut app, &format!("{}={default}", setting.name));
    }
    let last = difference(&first, &anew(&mut app, "resolution=8"));
    assert!(last < 2.0 * noise + 0.05, "all settings are back: {last}");

    // Steps of propagation matter where light is propagated.
    set(&mut app, "solver=propagate");
    let many = picture(&mut app, 0.0);
    set(&mut app, "iterations=4");
    let few = picture(&mut app, 0.0);
    assert!(difference(&many, &few) > 1.0);
}

#[test]
#[ignore = "long: many frames"]
fn sun_and_door_move_when_asked_to() {
    let _gpu = gpu();
    let mut app = app(&["resolution=16", "sun_motion=false", "door=closed"]);
    let first = picture(&mut app, 0.0);
    pass_time(&mut app, 5.0);
    let still = difference(&first, &picture(&mut app, 0.0));
    assert!(still < 0.5, "nothing moves: {still}");
    set(&mut app, "sun_motion=true");
    let sun = picture(&mut app, 0.0);
    let moved = difference(&first, &sun);
    assert!(moved > 2.0, "the sun: {moved}");
    set(&mut app, "door=swinging");
    let moved = difference(&sun, &picture(&mut app, 0.0));
    assert!(moved > 2.0, "the door: {moved}");
}

#[test]
#[ignore = "long: many frames"]
fn the_cornell_box_is_beside_its_truth() {
    let _gpu = gpu();
    let mut app = app(&["scene=cornell", "resolution=16", "paths=64"]);
    let half = |image: &RgbImage, right: u32| {
        let crop = image::imageops::crop_imm(image, 64 * right, 0, 64, 72);
        crop.to_image()
    };
    let [before, after] = sides(&mut app);
    let truth = half(&after, 1);
    assert!(
        difference(&truth, &half(&before, 1)) < 0.1,
        "it has no sides"
    );
    let [without, with] = [&before, &after].map(|image| difference(&half(image, 0), &truth));
    assert!(with < 0.8 * without, "{with} for {without}");
    let text = note(&app, "path tracing:");
    let error: f64 = text
        .split('%')
        .next()
        .and_then(|number| number.parse().ok())
        .unwrap_or_else(|| panic!("no figure: {text}"));
    println!("{text}");
    assert!(error < 7.5, "{text}");

    // The room comes back without it.
    set(&mut app, "scene=sunlit_room");
    picture(&mut app, 0.0);
    assert!(note(&app, "path tracing:").is_empty());
    let room = picture(&mut app, 1.0);
    assert!(difference(&half(&room, 1), &truth) > 20.0);
}

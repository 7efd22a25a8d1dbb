//! Scenes with two sides, and settings from the command line.

use bevy::prelude::*;
use bevy_frugal_lab::{
    gallery, metrics,
    runner::{
        Options, Scene, SceneSetting, SceneSettings, SettingError, Side, Size,
        pictures::headless_app, render_headless,
    },
};
use indicatif::ProgressBar;
use proptest::prelude::*;

use crate::{
    scenes::{joined, picture, sides},
    support::gpu,
};

/// A cube that is red before and green after, turning if asked to.
struct TwoCubes;

impl Scene for TwoCubes {
    fn name(&self) -> &'static str {
        "two_cubes"
    }

    fn plugin(&self) -> &'static str {
        "none"
    }

    fn description(&self) -> &'static str {
        "A red & a green cube"
    }

    fn settings(&self) -> Vec<SceneSetting> {
        vec![SceneSetting::toggle("same", "both are red", false)]
    }

    fn view(&self) -> Transform {
        Transform::from_xyz(0.5, 1.0, 1.5).looking_at(Vec3::ZERO, Vec3::Y)
    }

    fn build(&self, app: &mut App) {
        app.add_systems(Startup, spawn).add_systems(Update, turn);
    }

    fn configure_camera(&self, camera: &mut EntityCommands, _: Side) {
        camera.insert(Msaa::Off);
    }
}

fn spawn(
    mut commands: Commands,
    settings: Res<SceneSettings>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let green = Color::srgb(0.1, 0.9, 0.1);
    let red = Color::srgb(0.9, 0.1, 0.1);
    for side in Side::BOTH {
        let is_green = side == Side::After && !settings.toggle("same");
        commands.spawn((
            side.layers(),
            Mesh3d(meshes.add(Cuboid::default())),
            MeshMaterial3d(materials.add(if is_green { green } else { red })),
        ));
    }
    commands.spawn((
        DirectionalLight::default(),
        Transform::from_xyz(1.0, 2.0, 3.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
}

fn turn(time: Res<Time>, mut cubes: Query<&mut Transform, With<Mesh3d>>) {
    for mut transform in &mut cubes {
        transform.rotation = Quat::from_rotation_y(time.elapsed_secs());
    }
}

fn options(set: &[&str]) -> Options {
    Options {
        frames: 2,
        ..Options::picture(97, 64, set)
    }
}

#[test]
fn the_picture_continues_across_the_split_line() {
    let _gpu = gpu();
    let mut app = headless_app(&TwoCubes, &options(&[])).expect("an app");
    let [before, after] = sides(&mut app);
    for (position, line) in [(0.5, 49), (0.01, 1), (0.99, 96)] {
        let both = picture(&mut app, position);
        let expected = joined([&before, &after], line);
        // Projections of a part and of the whole round differently at the edges of the cube.
        let error = metrics::compare(&expected, &both).expect("equal sizes");
        assert!(error.mse < 20.0, "split at {position}: {error:?}");
    }
    let different = metrics::compare(&before, &after).expect("equal sizes");
    assert!(different.mse > 500.0, "{different:?}");
}

#[test]
fn pictures_figures_and_page_are_written() {
    let _gpu = gpu();
    let folder = std::env::temp_dir().join(format!("bevy_frugal_lab_{}", std::process::id()));
    gallery::render_all(&[&TwoCubes], &options(&[]), &folder).expect("pictures");
    let entries = std::fs::read_dir(&folder).expect("a folder");
    let mut names: Vec<_> = entries
        .map(|entry| entry.expect("an entry").file_name())
        .collect();
    names.sort();
    assert_eq!(
        names,
        [
            "index.html",
            "two_cubes_after.png",
            "two_cubes_before.png",
            "two_cubes_difference.png"
        ]
    );
    let page = std::fs::read_to_string(folder.join("index.html")).expect("a page");
    assert!(page.contains("two_cubes_before.png") && page.contains("A red &amp; a green cube"));
    std::fs::remove_dir_all(&folder).expect("a folder");
}

#[test]
fn equal_sides_of_a_moving_scene_are_equal() {
    let _gpu = gpu();
    let folder = std::env::temp_dir().join(format!("bevy_frugal_equal_{}", std::process::id()));
    let same = options(&["same=true"]);
    let outcome =
        render_headless(&TwoCubes, &same, &folder, &ProgressBar::hidden()).expect("pictures");
    std::fs::remove_dir_all(&folder).expect("a folder");
    assert_eq!(
        (outcome.mse, outcome.psnr_db, outcome.max_error),
        (0.0, None, 0)
    );
    let json: serde_json::Value = serde_json::from_str(&outcome.json_line()).expect("JSON");
    assert_eq!(json["settings"]["same"], true);
    assert_eq!(json["width"], 97);
}

#[test]
fn wrong_settings_are_refused_before_rendering() {
    let error = headless_app(&TwoCubes, &options(&["other=1"])).err();
    assert!(error.is_some_and(|error| error.to_string().contains("same=false")));
}

proptest! {
    #[test]
    fn no_text_panics_and_what_is_shown_can_be_set(
        text in "(on|height|count|kind|x)?=?[-+.0-9a-zA-Z]{0,8}",
        noise in ".{0,20}",
    ) {
        let mut settings = settings();
        let _ = settings.set(&noise);
        let _ = settings.set(&text);
        let shown: Vec<_> = settings.iter().map(|(k, v)| format!("{}={v}", k.name)).collect();
        let before = settings.clone();
        for text in shown {
            settings.set(&text).expect("its own text");
        }
        prop_assert_eq!(settings, before);
    }
}

fn settings() -> SceneSettings {
    SceneSettings::new(vec![
        SceneSetting::toggle("on", "a switch", false),
        SceneSetting::float("height", "a length", 0.5, 0.0..=2.0, "m"),
        SceneSetting::integer("count", "a number", 3, 1..=8, ""),
        SceneSetting::choice("kind", "a name", 1, &["red", "green"]),
    ])
}

#[test]
fn every_kind_is_set_by_name() {
    let mut settings = settings();
    assert_eq!(settings.choice("kind"), "green");
    for text in ["on=true", "height=1.25", "count=8", "kind=red"] {
        settings.set(text).expect(text);
    }
    assert!(settings.toggle("on"));
    assert_eq!(settings.float("height"), 1.25);
    assert_eq!(settings.integer("count"), 8);
    assert_eq!(settings.choice("kind"), "red");
}

#[test]
fn what_does_not_fit_changes_nothing_and_lists_the_settings() {
    let mut settings = settings();
    let before = settings.clone();
    for text in [
        "",
        "on",
        "off=true",
        "on=1",
        "on=",
        "height=-0.1",
        "height=NaN",
        "height=inf",
        "count=0",
        "count=9",
        "count=2.5",
        "kind=blue",
        "kind=red=green",
        " on=true",
    ] {
        let error = settings.set(text).expect_err(text).to_string();
        assert!(error.contains("height=0.5 (0 to 2 m): a length"), "{error}");
        assert!(error.contains("kind=green (red, green)"), "{error}");
    }
    assert_eq!(settings, before);
    assert!(matches!(
        settings.set("x=1"),
        Err(SettingError::Unknown { .. })
    ));
    assert!(matches!(settings.set("x"), Err(SettingError::Form { .. })));
}

#[test]
fn sizes_are_two_positive_numbers() {
    let parse = |text: &str| text.parse::<Size>();
    let size = parse("640x1").expect("a size");
    assert_eq!((size.width, size.height), (640, 1));
    for text in [
        "",
        "640",
        "x",
        "0x5",
        "5x0",
        "-1x5",
        "5x5x5",
        "5 x 5",
        "99999999999x1",
    ] {
        assert!(parse(text).is_err(), "{text}");
    }
}

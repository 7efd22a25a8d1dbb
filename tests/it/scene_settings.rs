//! Settings from the command line.

use bevy_frugal_lab::runner::{SceneSetting, SceneSettings, SettingError, Size};
use proptest::prelude::*;

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

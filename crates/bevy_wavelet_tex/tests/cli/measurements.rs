//! Tests of the measurements of the tool.

use std::fs;

use image::{DynamicImage, Rgb};

use crate::support::{Folder, color_image, gray_image, normal_image};

#[test]
fn bench_reports_what_encode_does() {
    let f = Folder::new("bench");
    fs::create_dir(f.0.join("set")).expect("made");
    f.save("set/one.png", color_image());
    f.save("set/two.png", gray_image());
    let rows = f.json(&["bench", "set", "--json"]);
    let rows = rows.as_array().expect("an array");
    assert_eq!(rows.len(), 18);
    for row in rows {
        let keys: Vec<_> = row.as_object().expect("an object").keys().collect();
        assert_eq!(keys, ["bpp", "encode_s", "image", "psnr_db", "rate"]);
        assert!(row["psnr_db"].as_f64() > Some(30.0) && row["encode_s"].as_f64() > Some(0.0));
    }
    let encoded = f.json(&[
        "encode",
        "set/one.png",
        "--rate",
        "color3",
        "--no-mips",
        "--json",
    ]);
    let row = rows
        .iter()
        .find(|r| r["image"] == "one" && r["rate"] == "color3");
    let row = row.expect("a row");
    for key in ["psnr_db", "bpp"] {
        let difference =
            row[key].as_f64().expect("a number") - encoded[0][key].as_f64().expect("one");
        assert!(difference.abs() < 1e-6, "{key}: {row} {encoded}");
    }
    let table = f.ok(&[
        "bench",
        "set",
        "--rates",
        "gray2,normal4",
        "--effort",
        "fast",
    ]);
    assert!(
        table.contains("gray2") && table.contains("normal4") && table.contains("mean"),
        "{table}"
    );
    f.fails(
        2,
        &["bench", "set", "--rates", "gray9"],
        &["gray9", "gray2"],
    );
}

#[test]
fn a_normal_map_has_no_angle_to_itself() {
    let f = Folder::new("angles");
    f.save("map.png", normal_image());
    let angles = f.json(&["compare", "map.png", "map.png", "--normal", "--json"]);
    assert_eq!(angles["max_angle_degrees"], 0.0);
}

/// Vectors in the maps of a game are 0.4 to 1.7 long, and nearly 0 between islands: what counts is the direction.
#[test]
fn normals_of_other_lengths_take_no_larger_rate() {
    let f = Folder::new("lengths");
    let unit = normal_image();
    let mut other = unit.clone();
    for (x, y, pixel) in other.enumerate_pixels_mut() {
        let length = if y < 32 { 0.8 } else { 1.2 };
        *pixel = match x {
            0..4 => Rgb([128, 127, 128]),
            _ => Rgb(pixel
                .0
                .map(|v| ((f32::from(v) - 127.5) * length + 127.5).round() as u8)),
        };
    }
    f.save("unit_normal.png", unit);
    f.save("other_normal.png", other);
    let of = |name: &str| {
        let encoded = f.json(&["encode", name, "--min-psnr", "40", "--json"]);
        let psnr = encoded[0]["psnr_db"].as_f64().expect("a number");
        (encoded[0]["bpp"].as_f64().expect("a number"), psnr)
    };
    let (unit, other) = (of("unit_normal.png"), of("other_normal.png"));
    println!("{unit:?} {other:?}");
    assert_eq!(other.0, unit.0);
    assert!(other.1 > 40.0);
    let psnr = f.psnr("other_normal.png", "other_normal.wtex");
    assert!((psnr - other.1).abs() < 0.1, "{psnr}");
}

/// Alpha that is not kept is no error of what is.
#[test]
fn alpha_that_is_dropped_does_not_count() {
    let f = Folder::new("dropped");
    let opaque = DynamicImage::from(normal_image()).into_rgba8();
    let mut transparent = opaque.clone();
    for (x, _, pixel) in transparent.enumerate_pixels_mut() {
        pixel.0[3] = if x < 32 { 0 } else { 255 };
    }
    f.save("opaque.png", opaque);
    f.save("transparent.png", transparent);
    for arguments in ["--role=normal", "--alpha=drop"] {
        let psnr = |name: &str| {
            let encoded = f.json(&["encode", name, "--json", arguments]);
            encoded[0]["psnr_db"].as_f64().expect("a number")
        };
        let (expected, found) = (psnr("opaque.png"), psnr("transparent.png"));
        assert!(
            (found - expected).abs() < 1e-6,
            "{arguments}: {found} {expected}"
        );
    }
    let psnr = f.psnr("transparent.png", "opaque.png");
    assert!(psnr < 20.0, "{psnr}");
}

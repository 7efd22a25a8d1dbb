//! Tests of the measurements of the tool.

use std::fs;

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

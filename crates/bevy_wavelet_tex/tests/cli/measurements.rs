//! Tests of the measurements of the tool.

use std::fs;

use image::GenericImageView;

use crate::support::{Folder, color_image, gray_image, normal_image};

#[test]
fn bench_reports_what_encode_does() {
    let f = Folder::new("bench");
    fs::create_dir(f.0.join("set")).expect("made");
    f.save("set/one.png", color_image());
    f.save("set/two.png", gray_image());
    let rows = f.json(&["bench", "set", "--json"]);
    let rows = rows.as_array().expect("an array");
    assert_eq!(rows.len(), 12);
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
fn tables_have_every_row_beside_the_published_ones() {
    let f = Folder::new("tables");
    f.save("in.png", color_image());
    let tables = f.json(&["tables", "in.png", "--json"]);
    assert_eq!(tables["images"], 1);
    for (table, rows) in [
        ("table_3_1", 4),
        ("table_3_3_wavelets", 4),
        ("table_3_3_color_spaces", 3),
    ] {
        let figures = tables[table].as_array().expect("an array");
        assert_eq!(figures.len(), rows, "{table}");
        for figure in figures {
            assert!(figure["here"].as_f64() > Some(0.0), "{table}: {figure}");
            assert!(figure["thesis"].as_f64() > Some(0.0), "{table}: {figure}");
        }
    }
    // Every transform has a small error on a smooth picture.
    for figure in tables["table_3_3_wavelets"].as_array().expect("an array") {
        assert!(figure["here"].as_f64() > Some(30.0), "{figure}");
    }
    // The rates are those of `bench`.
    let rows = f.json(&["bench", "in.png", "--study", "--json"]);
    let rows = rows.as_array().expect("an array");
    let rates = tables["rates"].as_array().expect("an array");
    assert_eq!(rates.len(), rows.len());
    for (rate, row) in rates.iter().zip(rows) {
        for key in ["rate", "bpp", "psnr_db"] {
            assert_eq!(rate[key], row[key], "{rate} {row}");
        }
    }
    let text = f.ok(&["tables", "in.png"]);
    let lines: Vec<&str> = text
        .lines()
        .filter(|l| l.starts_with("| color3 |"))
        .collect();
    let cells: Vec<&str> = lines[0].split('|').map(str::trim).collect();
    assert_eq!((cells[4], cells[5]), ("33.4", "BC1"), "{text}");
    assert!(!cells[6].is_empty() && !cells[7].is_empty(), "{text}");

    f.save("tiny.png", gray_image().view(0, 0, 8, 8).to_image());
    f.fails(1, &["tables", "tiny.png"], &["tiny.png", "16 x 16"]);
}

#[test]
fn normals_are_measured_beside_their_rivals() {
    let f = Folder::new("angles");
    f.save("map.png", normal_image());
    f.save("gray.png", gray_image());
    let rows = f.json(&["normals", "map.png", "--picture", "light.png", "--json"]);
    let mean = |map: &str, format: &str| {
        let mut rows = rows.as_array().expect("an array").iter();
        let row = rows.find(|r| r["map"] == map && r["format"] == format);
        let row = row.unwrap_or_else(|| panic!("no {map} in {format}: {rows:?}"));
        let angle = |key: &str| row[key].as_f64().expect("a number");
        let mean = angle("mean_angle_degrees");
        let p99 = angle("p99_angle_degrees");
        assert!(mean <= p99 && p99 <= angle("max_angle_degrees"), "{row}");
        mean
    };
    for map in ["smooth", "rough", "map"] {
        // BC5 has twice the bits of `normal4`, BC1 as many.
        assert!(mean(map, "normal4") < mean(map, "BC1"), "{map}");
        assert!(mean(map, "BC5") < mean(map, "BC1"), "{map}");
    }
    assert!(mean("smooth", "normal4") < 0.2);
    assert!(mean("map", "BC5 of a lower resolution") < 5.0);
    let picture = image::open(f.0.join("light.png"))
        .expect("a PNG")
        .into_luma8();
    assert_eq!(picture.dimensions(), (1280, 640));
    // The exact map has no error anywhere; that of BC1 is visible.
    let lower = |panel: u32| {
        let shown = (320..640).flat_map(|y| (320 * panel..320 * (panel + 1)).map(move |x| (x, y)));
        shown
            .map(|(x, y)| picture.get_pixel(x, y)[0].abs_diff(128))
            .max()
    };
    assert_eq!(lower(0), Some(0));
    assert!(lower(1) > Some(100) && lower(3) < lower(1));

    f.fails(
        1,
        &["normals", "gray.png"],
        &["gray.png", "not a normal map"],
    );
    f.fails(
        1,
        &["normals", "--picture", "no/light.png"],
        &["no/light.png", "cannot be written"],
    );
    let angles = f.json(&["compare", "map.png", "map.png", "--normal", "--json"]);
    assert_eq!(angles["max_angle_degrees"], 0.0);
}

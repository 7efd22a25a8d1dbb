//! Round trips from PNGs to textures and back, and what the tool measures of them.

use std::path::Path;

use image::{DynamicImage, GrayImage, ImageBuffer, Luma, Rgb, RgbImage, Rgba, RgbaImage};
use serde_json::json;

use crate::{Folder, color_image, gray_image, normal_image, skipped};

#[test]
fn color_goes_round() {
    let f = Folder::new("color");
    f.save("in.png", color_image());
    let line = f.ok("encode in.png"); // to in.wtex
    assert!(line.contains("in.wtex: 75 x 46 pixels"), "{line}");
    f.ok("decode in.wtex out.png");
    assert!(f.psnr("in.png", "out.png") > 33.0);
    assert_eq!(f.psnr("in.png", "out.png"), f.psnr("in.png", "in.wtex"));
    let printed = format!("{:.2} dB", f.psnr("in.png", "out.png"));
    assert!(line.contains(&printed), "{line}");

    f.ok("decode in.wtex mip.png --level 2");
    let mip = f.open("mip.png");
    assert_eq!((mip.width(), mip.height()), (18, 11));
    let identical = f.json("compare in.png in.png --json");
    assert!(identical["psnr_db"].is_null());
    assert_eq!(identical["mse"], 0.0);
}

#[test]
fn gray_goes_round_from_gray_and_from_color() {
    let f = Folder::new("gray");
    f.save("gray.png", gray_image());
    f.save("color.png", color_image());
    f.ok("encode gray.png gray.wtex --linear");
    f.ok("encode color.png color.wtex --rate gray2");
    for name in ["gray", "color"] {
        let [png, wtex, out] = ["png", "wtex", "out.png"].map(|e| format!("{name}.{e}"));
        f.ok(&format!("decode {wtex} {out}"));
        let decoded = f.open(&out);
        assert!(matches!(decoded, DynamicImage::ImageLuma8(_)));
        assert!(f.psnr(&png, &out) > 33.0, "{name}");
        assert_eq!(f.info(&wtex)["content"], "gray");
    }
    let text = f.ok("compare color.png color.out.png");
    assert!(text.contains("luma: color.out.png is gray"), "{text}");
    let space = |file| f.info(file)["color_space"].clone();
    assert_eq!(space("gray.wtex"), "linear");
    assert_eq!(space("color.wtex"), "srgb");
}

#[test]
fn normals_go_round() {
    let f = Folder::new("normal");
    f.save("in.png", normal_image());
    f.ok("encode in.png in.wtex --role normal");
    let difference = f.json("compare in.png in.wtex --json");
    let angle = difference["mean_angle_degrees"].as_f64();
    assert!(angle.is_some_and(|a| a > 0.0 && a < 2.0), "{difference}");
    assert_eq!(f.info("in.wtex")["color_space"], "linear");
}

#[test]
fn info_describes_every_plane() {
    let f = Folder::new("info");
    f.save("in.png", color_image());
    f.ok("encode in.png in.wtex --no-mips --effort best");
    let info = f.info("in.wtex");
    assert_eq!(info["version"], 2);
    assert_eq!(info["size"], json!([75, 46]));
    assert_eq!(info["levels"], 1);
    let planes = info["planes"].as_array().expect("planes");
    let names: Vec<_> = planes.iter().map(|p| &p["name"]).collect();
    assert_eq!(names, ["Y", "Co", "Cg"]);
    for plane in planes {
        assert!(plane["low_range"][0].as_f64() < plane["low_range"][1].as_f64());
        let wavelet = plane["name"] == "Y";
        assert_eq!(plane["detail_range"].as_f64() > Some(0.0), wavelet);
        assert_eq!(
            plane["gamma"].is_number() && plane["predictor"].is_number(),
            wavelet
        );
    }
    assert_eq!(planes[1]["packing"], "bc1");
    assert_eq!(planes[1]["size"], json!([38, 23]));
    let text = f.ok("info in.wtex");
    assert!(
        text.contains("color, srgb, 75 x 46 pixels, mip levels: 1"),
        "{text}"
    );
}

#[test]
fn other_pngs_are_converted() {
    let f = Folder::new("convert");
    let wide = ImageBuffer::<Luma<u16>, Vec<u16>>::from_fn(16, 16, |x, _| Luma([x as u16 * 4000]));
    f.save("wide.png", DynamicImage::ImageLuma16(wide));
    f.ok("encode wide.png");
    assert_eq!(f.info("wide.wtex")["content"], "gray");

    let clear = RgbaImage::from_pixel(8, 8, Rgba([9, 99, 200, 7]));
    f.save("clear.png", clear.clone());
    f.save("opaque.png", DynamicImage::from(clear).into_rgb8());
    assert_eq!(f.run("encode clear.png").errors, "");
    assert_eq!(f.info("clear.wtex")["content"], "color_alpha");
    f.ok("encode clear.png --alpha=drop");
    f.ok("encode opaque.png");
    assert_eq!(f.texture("clear.wtex"), f.texture("opaque.wtex"));
    let ran = f.run("encode clear.png --rate gray2");
    ran.says("clear.png");
    ran.says("alpha is dropped");
}

#[test]
fn mips_end_at_one_pixel_for_every_size() {
    let f = Folder::new("chains");
    for (width, height) in [
        (1000, 1000),
        (600, 400),
        (1920, 1080),
        (576, 17),
        (34, 1),
        (3, 5),
    ] {
        let image = RgbImage::from_fn(width, height, |x, y| {
            let v = |f: f32, t: u32| 127.5 + 90.0 * (t as f32 * f / width as f32).sin();
            Rgb([v(9.0, x), v(5.0, y), v(7.0, x + y)].map(|v| v as u8))
        });
        f.save("in.png", image.clone());
        for rate in ["", "--rate color2.25", "--rate gray3"] {
            let line = "encode in.png in.wtex --formats wavelet --effort fast --json";
            let rows = f.json(&format!("{line} {rate}"));
            let levels = rows[0]["levels"].as_u64().expect("a number") as u32;
            let expected = u32::BITS - width.max(height).leading_zeros();
            assert_eq!(levels, expected, "{rows}");
            for level in 1..levels {
                let size = [width, height].map(|s: u32| (s >> level).max(1));
                let decoded = f.level("in.wtex", level);
                assert_eq!([decoded.width(), decoded.height()], size);
            }
        }
    }
}

/// Tests a test image of the thesis, where it is at hand.
#[test]
fn kodim23_keeps_its_quality() {
    let kodak = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data/kodak");
    let source = kodak.join("kodim23.png");
    if !source.exists() {
        skipped("quality of kodim23: the Kodak images are not there");
        return;
    }
    let source = source.to_str().expect("UTF-8");
    let f = Folder::new("kodak");
    for (rate, floor) in [("gray2", 37.0), ("3", 35.5)] {
        f.ok(&format!("encode {source} out.wtex --rate {rate}"));
        f.ok("decode out.wtex out.png");
        let psnr = f.psnr(source, "out.png");
        assert!(psnr >= floor, "rate {rate}: {psnr} dB");
    }
}

#[test]
fn every_rate_encodes_every_kind_of_png() {
    let f = Folder::new("kinds");
    f.save("color.png", color_image());
    f.save("gray.png", gray_image());
    let wide = ImageBuffer::<Rgb<u16>, Vec<u16>>::from_fn(33, 17, |x, y| {
        Rgb([x as u16 * 1900, y as u16 * 3000, 30000])
    });
    f.save("wide.png", DynamicImage::ImageRgb16(wide));
    for rate in [
        "gray2",
        "gray3",
        "color2.25",
        "color3",
        "color3.25",
        "color5",
        "normal4",
    ] {
        for name in ["color", "gray", "wide"] {
            let png = format!("{name}.png");
            let rows = f.json(&format!("encode {png} --rate {rate} --json --effort fast"));
            let psnr = rows[0]["psnr_db"].as_f64();
            // A picture is not a normal map, so the test only requires that it can be encoded as
            // one.
            assert!(
                psnr > Some(30.0) || rate == "normal4",
                "{rate} {name}: {rows}"
            );
            f.ok(&format!("decode {name}.wtex back.png"));
        }
    }
}

#[test]
fn alpha_is_kept_on_demand_and_large_images_are_made_smaller() {
    let f = Folder::new("alpha");
    let image = RgbaImage::from_fn(64, 48, |x, y| {
        Rgba([
            200,
            (3 * y) as u8,
            40,
            if x < 32 { 255 } else { (4 * y) as u8 },
        ])
    });
    f.save("in.png", image);
    let rows = f.json("encode in.png --alpha --json");
    assert_eq!(rows[0]["content"], "color_alpha");
    f.ok("decode in.wtex out.png");
    let decoded = f.open("out.png").into_rgba8();
    assert!(decoded.get_pixel(5, 5)[3] > 250 && decoded.get_pixel(60, 2)[3] < 20);
    assert!(f.psnr("in.png", "out.png") > 35.0);

    let rows = f.json("encode in.png --alpha --max-size 20 --json");
    assert_eq!(rows[0]["size"], json!([16, 12]));
}

#[test]
fn zstandard_changes_the_file_and_not_the_texture() {
    let f = Folder::new("zstd");
    // Two tones compress well.
    f.save(
        "in.png",
        GrayImage::from_fn(64, 64, |x, y| Luma([if x > y { 200 } else { 40 }])),
    );
    f.ok("encode in.png stored.wtex");
    f.ok("encode --zstd in.png zstd.wtex");
    f.ok("encode in.png fast.wtex --zstd=1");
    for (file, flags) in [("stored", 0), ("zstd", 1), ("fast", 1)] {
        let texture = format!("{file}.wtex");
        f.ok(&format!("decode {texture} out.png"));
        assert_eq!(f.read(&texture)[9] & 1, flags, "{file}");
        let difference = f.json("compare out.png stored.wtex --json");
        assert_eq!(difference["mse"], 0.0, "{file}");
    }
    let length = |file: &str| f.read(file).len();
    assert!(length("zstd.wtex") <= length("fast.wtex"));
    assert!(length("fast.wtex") < length("stored.wtex"));
    f.fails(2, "encode in.png --zstd=23", &["23", "1..=22"]);
}

#[test]
fn bench_reports_what_encode_does() {
    let f = Folder::new("bench");
    f.save("set/one.png", color_image());
    f.save("set/two.png", gray_image());
    let rows = f.json("bench set --json");
    let rows = rows.as_array().expect("an array");
    assert_eq!(rows.len(), 18);
    for row in rows {
        let keys: Vec<_> = row.as_object().expect("an object").keys().collect();
        assert_eq!(keys, ["bpp", "encode_s", "image", "psnr_db", "rate"]);
        assert!(row["psnr_db"].as_f64() > Some(30.0) && row["encode_s"].as_f64() > Some(0.0));
    }
    let encoded = f.json("encode set/one.png --rate color3 --no-mips --json");
    let row = rows
        .iter()
        .find(|r| r["image"] == "one" && r["rate"] == "color3");
    let row = row.expect("a row");
    for key in ["psnr_db", "bpp"] {
        let difference =
            row[key].as_f64().expect("a number") - encoded[0][key].as_f64().expect("one");
        assert!(difference.abs() < 1e-6, "{key}: {row} {encoded}");
    }
    let table = f.ok("bench set --rates gray2,normal4 --effort fast");
    assert!(
        table.contains("gray2") && table.contains("normal4") && table.contains("mean"),
        "{table}"
    );
    f.fails(2, "bench set --rates gray9", &["gray9", "gray2"]);
}

#[test]
fn a_normal_map_has_no_angle_to_itself() {
    let f = Folder::new("angles");
    f.save("map.png", normal_image());
    let angles = f.json("compare map.png map.png --normal --json");
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
        let encoded = f.json(&format!("encode {name} --min-psnr 40 --json"));
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
            let encoded = f.json(&format!("encode {name} --json {arguments}"));
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

//! The `wavelet-tex` tool as its users run it.

use std::{
    fs,
    path::{Path, PathBuf},
    process::{Command, Output},
};

use image::{DynamicImage, GrayImage, ImageBuffer, Luma, Rgb, RgbImage, Rgba, RgbaImage};
use serde_json::Value;

/// A folder of one test, removed with it.
struct Folder(PathBuf);

impl Folder {
    fn new(test: &str) -> Self {
        let name = format!("wavelet-tex-{test}-{}", std::process::id());
        let path = std::env::temp_dir().join(name);
        fs::create_dir_all(&path).expect("a temporary folder");
        Self(path)
    }

    /// Runs the tool in the folder.
    fn run(&self, args: &[&str]) -> Output {
        let output = Command::new(env!("CARGO_BIN_EXE_wavelet-tex"))
            .current_dir(&self.0)
            .args(args)
            .output()
            .expect("the tool starts");
        let errors = stderr(&output);
        assert!(!errors.contains("panicked"), "{args:?}: {errors}");
        output
    }

    /// Runs the tool, which must succeed; its standard output.
    fn ok(&self, args: &[&str]) -> String {
        let output = self.run(args);
        assert!(output.status.success(), "{args:?}: {}", stderr(&output));
        String::from_utf8(output.stdout).expect("UTF-8")
    }

    fn json(&self, args: &[&str]) -> Value {
        serde_json::from_str(&self.ok(args)).expect("JSON")
    }

    /// Runs the tool, which must fail with this code and these words, and leave the folder as it was.
    fn fails(&self, code: i32, args: &[&str], words: &[&str]) {
        let before = self.contents();
        let output = self.run(args);
        let errors = stderr(&output);
        assert_eq!(output.status.code(), Some(code), "{args:?}: {errors}");
        for word in words {
            assert!(errors.contains(word), "{args:?}: no {word:?} in: {errors}");
        }
        assert_eq!(self.contents(), before, "{args:?}");
    }

    /// Names and lengths of all files.
    fn contents(&self) -> Vec<(String, u64)> {
        let mut files: Vec<_> = fs::read_dir(&self.0)
            .expect("the folder")
            .map(|entry| {
                let entry = entry.expect("an entry");
                let length = entry.metadata().expect("metadata").len();
                (entry.file_name().to_string_lossy().into_owned(), length)
            })
            .collect();
        files.sort();
        files
    }

    fn save(&self, name: &str, image: impl Into<DynamicImage>) {
        image.into().save(self.0.join(name)).expect("a PNG");
    }

    fn write(&self, name: &str, bytes: &[u8]) {
        fs::write(self.0.join(name), bytes).expect("a file");
    }

    fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.0.join(name)).expect("a file")
    }

    fn psnr(&self, a: &str, b: &str) -> f64 {
        let difference = self.json(&["compare", a, b, "--json"]);
        difference["psnr_db"].as_f64().expect("a number")
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Smooth colours with a few edges, of a size that is no multiple of a block.
fn color_image() -> RgbImage {
    RgbImage::from_fn(75, 46, |x, y| {
        let wave = |f: f32, p: f32| 127.5 + 90.0 * (x as f32 * f + y as f32 * 0.07 + p).sin();
        let edge = if (x / 20 + y / 15) % 2 == 0 {
            25.0
        } else {
            0.0
        };
        Rgb([wave(0.11, 0.0), wave(0.05, 1.0), wave(0.08, 2.0)].map(|v| (v + edge) as u8))
    })
}

fn gray_image() -> GrayImage {
    DynamicImage::from(color_image()).to_luma8()
}

/// A bump map's normals.
fn normal_image() -> RgbImage {
    RgbImage::from_fn(64, 64, |x, y| {
        let (dx, dy) = ((x as f32 * 0.2).cos() * 0.5, (y as f32 * 0.15).sin() * 0.5);
        let length = (dx * dx + dy * dy + 1.0).sqrt();
        Rgb([-dx, -dy, 1.0].map(|v| (127.5 + 127.5 * v / length).round() as u8))
    })
}

#[test]
fn color_goes_round() {
    let f = Folder::new("color");
    f.save("in.png", color_image());
    let line = f.ok(&["encode", "in.png"]); // to in.wtex
    assert!(line.contains("in.wtex: 75 x 46 pixels"), "{line}");
    f.ok(&["decode", "in.wtex", "out.png"]);
    assert!(f.psnr("in.png", "out.png") > 33.0);
    assert_eq!(f.psnr("in.png", "out.png"), f.psnr("in.png", "in.wtex"));
    let printed = format!("{:.2} dB", f.psnr("in.png", "out.png"));
    assert!(line.contains(&printed), "{line}");

    f.ok(&["decode", "in.wtex", "mip.png", "--level", "2"]);
    let mip = image::open(f.0.join("mip.png")).expect("a PNG");
    assert_eq!((mip.width(), mip.height()), (18, 11));
    let identical = f.json(&["compare", "in.png", "in.png", "--json"]);
    assert!(identical["psnr_db"].is_null());
    assert_eq!(identical["mse"], 0.0);
}

#[test]
fn gray_goes_round_from_gray_and_from_color() {
    let f = Folder::new("gray");
    f.save("gray.png", gray_image());
    f.save("color.png", color_image());
    f.ok(&["encode", "gray.png", "gray.wtex", "--linear"]);
    f.ok(&["encode", "color.png", "color.wtex", "--rate", "gray2"]);
    for name in ["gray", "color"] {
        let [png, wtex, out] = ["png", "wtex", "out.png"].map(|e| format!("{name}.{e}"));
        f.ok(&["decode", &wtex, &out]);
        let decoded = image::open(f.0.join(&out)).expect("a PNG");
        assert!(matches!(decoded, DynamicImage::ImageLuma8(_)));
        assert!(f.psnr(&png, &out) > 33.0, "{name}");
        assert_eq!(f.json(&["info", &wtex, "--json"])["content"], "gray");
    }
    let text = f.ok(&["compare", "color.png", "color.out.png"]);
    assert!(text.contains("luma: color.out.png is gray"), "{text}");
    let space = |file| f.json(&["info", file, "--json"])["color_space"].clone();
    assert_eq!(space("gray.wtex"), "linear");
    assert_eq!(space("color.wtex"), "srgb");
}

#[test]
fn normals_go_round() {
    let f = Folder::new("normal");
    f.save("in.png", normal_image());
    f.ok(&["encode", "in.png", "in.wtex", "--role", "normal"]);
    let difference = f.json(&["compare", "in.png", "in.wtex", "--json"]);
    let angle = difference["mean_angle_degrees"].as_f64();
    assert!(angle.is_some_and(|a| a > 0.0 && a < 2.0), "{difference}");
    assert_eq!(
        f.json(&["info", "in.wtex", "--json"])["color_space"],
        "linear"
    );
}

#[test]
fn info_describes_every_plane() {
    let f = Folder::new("info");
    f.save("in.png", color_image());
    f.ok(&[
        "encode",
        "in.png",
        "in.wtex",
        "--no-mips",
        "--effort",
        "best",
    ]);
    let info = f.json(&["info", "in.wtex", "--json"]);
    assert_eq!(info["version"], 2);
    assert_eq!(info["size"], serde_json::json!([75, 46]));
    assert_eq!(info["levels"], 1);
    let planes = info["planes"].as_array().expect("planes");
    let names: Vec<_> = planes.iter().map(|p| &p["name"]).collect();
    assert_eq!(names, ["Y", "Co", "Cg"]);
    for plane in planes {
        assert!(plane["mean_range"][0].as_f64() < plane["mean_range"][1].as_f64());
        let wavelet = plane["name"] == "Y";
        assert_eq!(plane["detail_range"].as_f64() > Some(0.0), wavelet);
        assert_eq!(
            plane["gamma"].is_number() && plane["predictor"].is_number(),
            wavelet
        );
    }
    assert_eq!(planes[1]["packing"], "bc1");
    assert_eq!(planes[1]["size"], serde_json::json!([38, 23]));
    let text = f.ok(&["info", "in.wtex"]);
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
    f.ok(&["encode", "wide.png"]);
    assert_eq!(f.json(&["info", "wide.wtex", "--json"])["content"], "gray");

    f.save(
        "clear.png",
        RgbaImage::from_pixel(8, 8, Rgba([9, 99, 200, 7])),
    );
    f.save(
        "opaque.png",
        RgbaImage::from_pixel(8, 8, Rgba([9, 99, 200, 255])),
    );
    let warning = stderr(&f.run(&["encode", "clear.png"]));
    assert!(warning.contains("clear.png") && warning.contains("alpha is dropped"));
    assert_eq!(stderr(&f.run(&["encode", "opaque.png"])), "");
    assert_eq!(f.read("clear.wtex"), f.read("opaque.wtex"));
}

#[test]
fn bad_input_is_named() {
    let f = Folder::new("bad");
    f.save("good.png", color_image());
    f.save("small.png", GrayImage::new(8, 8));
    f.ok(&["encode", "good.png", "good.wtex"]);
    let (png, wtex) = (f.read("good.png"), f.read("good.wtex"));
    f.write("empty", b"");
    f.write("text", b"neither of them");
    f.write("short.png", &png[..png.len() / 2]);
    f.write("signature.png", &png[..8]);
    f.write("short.wtex", &wtex[..wtex.len() / 2]);
    f.write("absurd.png", &with_size(&png, [0x7fff_ffff, 0x7fff_ffff]));
    f.write("wide.png", &with_size(&png, [16385, 1]));
    f.write("newer.wtex", &[&wtex[..8], &[9, 0], &wtex[10..]].concat());

    for (file, words) in [
        ("missing", "cannot be read"),
        ("empty", "the file is empty"),
        ("text", "not a PNG: convert"),
        ("good.wtex", "wavelet-tex decode"),
        ("short.png", "cannot be decoded"),
        ("signature.png", "cannot be decoded"),
        ("absurd.png", "2147483647 x 2147483647"),
        ("wide.png", "16385 x 1"),
    ] {
        f.fails(1, &["encode", file, "new.wtex"], &[file, words]);
    }
    for (file, words) in [
        ("missing", "cannot be read"),
        ("empty", "the file is empty"),
        ("good.png", "not a wavelet texture"),
        ("short.wtex", "cut short"),
        ("newer.wtex", "version 9 is newer"),
    ] {
        f.fails(1, &["decode", file, "new.png"], &[file, words]);
        f.fails(1, &["info", file], &[file, words]);
    }
    for (file, words) in [
        ("missing", "cannot be read"),
        ("empty", "the file is empty"),
        ("text", "neither a PNG nor a wavelet texture"),
        ("short.png", "cannot be decoded"),
        ("short.wtex", "cut short"),
        ("small.png", "only images of one size"),
    ] {
        f.fails(1, &["compare", "good.wtex", file], &[file, words]);
    }
    f.fails(
        1,
        &["decode", "good.wtex", "new.png", "--level", "40"],
        &["good.wtex", "no level 40: its levels are 0 to"],
    );
}

#[test]
fn bad_usage_is_named() {
    let f = Folder::new("usage");
    f.save("in.png", color_image());
    f.fails(2, &["encode"], &["INPUT"]);
    f.fails(2, &["encode", "in.png", "--rate", "7"], &["'7'", "color3"]);
    f.fails(2, &["encode", "in.png", "--role", "depth"], &["normal"]);
    f.fails(2, &["encode", "in.png", "--effort", "all"], &["best"]);
    f.fails(
        2,
        &["encode", "in.png", "--role", "normal", "--rate", "3"],
        &["normal cannot be coded at 3", "normal4"],
    );
    f.fails(2, &["encode", "in.png", "--rate", "auto"], &["--min-psnr"]);
    f.fails(
        2,
        &["encode", "in.png", "--rate", "color3", "--min-psnr", "40"],
        &["leave --rate away"],
    );
    f.fails(2, &["encode", "in.png", "--min-psnr", "many"], &["in dB"]);
    f.fails(
        2,
        &["encode", "in.png", "--out", "out.png"],
        &["out.png", ".wtex"],
    );
    f.fails(2, &["decode", "in.wtex", "out.jpg"], &["out.jpg", ".png"]);
}

#[test]
fn outputs_never_cost_a_file() {
    let f = Folder::new("outputs");
    f.save("in.png", color_image());
    fs::create_dir(f.0.join("folder.wtex")).expect("a folder");
    // The same file by another name.
    fs::hard_link(f.0.join("in.png"), f.0.join("link.wtex")).expect("a link");
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("in.png", f.0.join("soft.wtex")).expect("a link");
        f.fails(
            1,
            &["encode", "in.png", "soft.wtex"],
            &["soft.wtex", "is the input"],
        );
    }
    f.fails(1, &["encode", "in.png", "folder.wtex"], &["is a directory"]);
    f.fails(
        1,
        &["encode", "in.png", "no/out.wtex"],
        &["no/out.wtex", "folder no"],
    );

    // A failure leaves what was there; success replaces it and leaves nothing else.
    f.write("out.wtex", b"precious");
    f.write("text", b"not an image");
    f.fails(1, &["encode", "text", "out.wtex"], &["text"]);
    assert_eq!(f.read("out.wtex"), b"precious");
    let before = f.contents().len();
    f.ok(&["encode", "in.png", "out.wtex"]);
    assert_ne!(f.read("out.wtex"), b"precious");
    assert_eq!(f.contents().len(), before);
}

/// The thesis's test image, where the checkout has it.
#[test]
fn kodim23_keeps_its_quality() {
    let kodak = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data/kodak");
    let source = kodak.join("kodim23.png");
    if !source.exists() {
        println!("skipped: {} is not there", source.display());
        return;
    }
    let source = source.to_str().expect("UTF-8");
    let f = Folder::new("kodak");
    for (rate, floor) in [("2", 37.0), ("3", 35.5)] {
        f.ok(&["encode", source, "out.wtex", "--rate", rate]);
        f.ok(&["decode", "out.wtex", "out.png"]);
        let psnr = f.psnr(source, "out.png");
        assert!(psnr >= floor, "rate {rate}: {psnr} dB");
    }
}

#[test]
fn a_bad_file_in_a_batch_stops_no_other_and_is_named_at_the_end() {
    let f = Folder::new("batch");
    for (name, image) in [
        ("a", gray_image()),
        ("sub/b", gray_image()),
        ("z", gray_image()),
    ] {
        let path = f.0.join("in").join(name).with_extension("png");
        fs::create_dir_all(path.parent().expect("a folder")).expect("made");
        image.save(path).expect("a PNG");
    }
    f.write("in/m.png", b"no image");
    f.write("in/note.txt", b"not looked at");
    let output = f.run(&["encode", "in", "--out", "out", "--json", "--effort", "fast"]);
    assert_eq!(output.status.code(), Some(1));
    let errors = stderr(&output);
    assert!(errors.contains("1 of 4 files failed"), "{errors}");
    assert!(
        errors.contains("in/m.png") && !errors.contains("note.txt"),
        "{errors}"
    );
    let rows: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(rows.as_array().map(Vec::len), Some(3), "{rows}");
    for name in ["out/a.wtex", "out/sub/b.wtex", "out/z.wtex"] {
        assert!(f.0.join(name).is_file(), "{name}");
        assert!(rows.to_string().contains(name), "{name} in {rows}");
    }
    for row in rows.as_array().expect("rows") {
        assert!(row["psnr_db"].as_f64() > Some(30.0) && row["bpp"].as_f64() > Some(2.0));
    }

    f.ok(&["decode", "out", "--out", "back"]);
    assert!(f.psnr("in/sub/b.png", "back/sub/b.png") > 33.0);
    assert_eq!(
        f.json(&["info", "out", "--json"]).as_array().map(Vec::len),
        Some(3)
    );
}

#[test]
fn globs_are_expanded_and_results_never_collide() {
    let f = Folder::new("glob");
    for name in ["a1.png", "a2.png", "b.png"] {
        f.save(name, gray_image());
    }
    let lines = f.ok(&["encode", "a?.png", "--effort", "fast"]);
    assert_eq!(lines.lines().count(), 2, "{lines}");
    assert!(f.0.join("a2.wtex").is_file() && !f.0.join("b.wtex").exists());
    f.fails(1, &["encode", "c*.png"], &["c*.png", "no file fits"]);
    fs::create_dir(f.0.join("empty")).expect("made");
    f.fails(1, &["encode", "empty"], &["empty", "no .png file"]);
    fs::create_dir(f.0.join("other")).expect("made");
    f.save("other/b.png", gray_image());
    let output = f.run(&["encode", "b.png", "other/b.png", "--out", "all"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(
        stderr(&output).contains("is that of b.png"),
        "{}",
        stderr(&output)
    );
    assert!(f.0.join("all/b.wtex").is_file());
}

#[test]
fn the_rate_follows_the_wanted_quality() {
    let f = Folder::new("auto");
    f.save("in.png", color_image());
    let mut last = 0.0;
    for wanted in ["20", "37", "40"] {
        let rows = f.json(&["encode", "in.png", "--min-psnr", wanted, "--json"]);
        let (bpp, psnr) = (rows[0]["bpp"].as_f64(), rows[0]["psnr_db"].as_f64());
        assert!(psnr >= wanted.parse().ok(), "{wanted}: {rows}");
        assert!(bpp >= Some(last), "{wanted}: {rows}");
        last = bpp.expect("a number");
    }
    assert!(last > 3.5, "{last}");
    let output = f.run(&["encode", "in.png", "--rate", "auto", "--min-psnr", "99"]);
    assert!(output.status.success());
    assert!(
        stderr(&output).contains("the largest rate reaches"),
        "{}",
        stderr(&output)
    );
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
            let rows = f.json(&["encode", &png, "--rate", rate, "--json", "--effort", "fast"]);
            let psnr = rows[0]["psnr_db"].as_f64();
            // A picture is no normal map; that it is coded as one is enough.
            assert!(
                psnr > Some(30.0) || rate == "normal4",
                "{rate} {name}: {rows}"
            );
            f.ok(&["decode", &format!("{name}.wtex")]);
            f.save("color.png", color_image());
            f.save("gray.png", gray_image());
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
    let rows = f.json(&["encode", "in.png", "--alpha", "--json"]);
    assert_eq!(rows[0]["content"], "color_alpha");
    f.ok(&["decode", "in.wtex", "out.png"]);
    let decoded = image::open(f.0.join("out.png"))
        .expect("a PNG")
        .into_rgba8();
    assert!(decoded.get_pixel(5, 5)[3] > 250 && decoded.get_pixel(60, 2)[3] < 20);
    assert!(f.psnr("in.png", "out.png") > 35.0);

    let rows = f.json(&["encode", "in.png", "--alpha", "--max-size", "20", "--json"]);
    assert_eq!(rows[0]["size"], serde_json::json!([16, 12]));
}

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
fn the_result_does_not_depend_on_the_number_of_threads() {
    let f = Folder::new("threads");
    f.save("in.png", color_image());
    let mut results = Vec::new();
    for threads in ["1", "2", "5"] {
        let output = Command::new(env!("CARGO_BIN_EXE_wavelet-tex"))
            .current_dir(&f.0)
            .env("RAYON_NUM_THREADS", threads)
            .args(["encode", "in.png", "--alpha"])
            .output()
            .expect("the tool starts");
        assert!(output.status.success());
        results.push(f.read("in.wtex"));
    }
    assert!(results.windows(2).all(|pair| pair[0] == pair[1]));
}

#[test]
fn images_inside_gltf_files_are_encoded_by_their_role() {
    let f = Folder::new("gltf");
    let mut binary = Vec::new();
    let mut views = Vec::new();
    for image in [color_image(), normal_image()] {
        let mut png = std::io::Cursor::new(Vec::new());
        let format = image::ImageFormat::Png;
        image.write_to(&mut png, format).expect("a PNG");
        let png = png.into_inner();
        views.push(serde_json::json!({
            "buffer": 0, "byteOffset": binary.len(), "byteLength": png.len()
        }));
        binary.extend(png);
    }
    f.save("apart.png", gray_image());
    let json = serde_json::json!({
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": binary.len()}],
        "bufferViews": views,
        "images": [
            {"bufferView": 0, "mimeType": "image/png"},
            {"bufferView": 1, "mimeType": "image/png"},
            {"uri": "apart.png"},
            {"uri": "unused.png"},
        ],
        "textures": [{"source": 0}, {"source": 1}, {"source": 2}, {"source": 3}],
        "materials": [{
            "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}},
            "normalTexture": {"index": 1},
            "occlusionTexture": {"index": 2},
        }],
    });
    let mut json = json.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut glb = b"glTF\x02\0\0\0\0\0\0\0".to_vec();
    for (kind, bytes) in [(b"JSON", &json), (b"BIN\0", &binary)] {
        glb.extend((bytes.len() as u32).to_le_bytes());
        glb.extend(kind);
        glb.extend(bytes);
    }
    f.write("model.glb", &glb);
    f.ok(&["encode", "model.glb", "--effort", "fast"]);
    let info = |file| f.json(&["info", file, "--json"]);
    assert_eq!(info("model.glb.Texture0.wtex")["content"], "color");
    assert_eq!(info("model.glb.Texture1.wtex")["content"], "normal");
    assert_eq!(info("apart.wtex")["content"], "gray");
    assert_eq!(info("apart.wtex")["color_space"], "linear");

    f.write("short.glb", &glb[..40]);
    f.fails(1, &["encode", "short.glb"], &["short.glb", "cut short"]);
    f.write(
        "bad.gltf",
        br#"{"materials": [{"normalTexture": {"index": 7}}]}"#,
    );
    f.fails(1, &["encode", "bad.gltf"], &["bad.gltf", "texture 7"]);
}

/// A PNG whose header claims another size.
fn with_size(png: &[u8], size: [u32; 2]) -> Vec<u8> {
    let mut png = png.to_vec();
    png[16..20].copy_from_slice(&size[0].to_be_bytes());
    png[20..24].copy_from_slice(&size[1].to_be_bytes());
    let crc = png[12..29].iter().fold(!0u32, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| {
            (crc >> 1) ^ (0xedb8_8320 & (crc & 1).wrapping_neg())
        })
    });
    png[29..33].copy_from_slice(&(!crc).to_be_bytes());
    png
}

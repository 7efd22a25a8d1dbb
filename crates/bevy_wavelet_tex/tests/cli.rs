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
    assert_eq!(info["version"], 1);
    assert_eq!(info["size"], serde_json::json!([75, 46]));
    assert_eq!(info["levels"], 1);
    let planes = info["planes"].as_array().expect("planes");
    let names: Vec<_> = planes.iter().map(|p| &p["name"]).collect();
    assert_eq!(names, ["Y", "Co", "Cg"]);
    for plane in planes {
        assert!(plane["mean_range"][0].as_f64() < plane["mean_range"][1].as_f64());
        assert!(plane["detail_range"].as_f64() > Some(0.0));
        assert!(plane["gamma"].is_number() && plane["transform"].is_string());
    }
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
        (".", "cannot be read"),
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
    f.fails(2, &["encode"], &["<INPUT>"]);
    f.fails(
        2,
        &["encode", "in.png", "--rate", "7"],
        &["'7'", "3 (color3)"],
    );
    f.fails(2, &["encode", "in.png", "--role", "depth"], &["normal"]);
    f.fails(2, &["encode", "in.png", "--effort", "all"], &["best"]);
    f.fails(
        2,
        &["encode", "in.png", "--role", "normal", "--rate", "3"],
        &["in.png", "normal cannot be coded at 3", "4 (normal4)"],
    );
    f.fails(2, &["encode", "in.png", "out.png"], &["out.png", ".wtex"]);
    f.fails(2, &["decode", "in.wtex", "out.jpg"], &["out.jpg", ".png"]);
}

#[test]
fn outputs_never_cost_a_file() {
    let f = Folder::new("outputs");
    f.save("in.png", color_image());
    fs::create_dir(f.0.join("folder.wtex")).expect("a folder");
    f.fails(
        1,
        &["encode", "in.png", "in.png"],
        &["in.png", "is the input"],
    );
    f.fails(1, &["encode", "in.png", "./in.png"], &["is the input"]);
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

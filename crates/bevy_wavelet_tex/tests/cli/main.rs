//! Tests of the `wavelet-tex` tool, run as its users run it, in a folder and on images of their own.

mod batch;
mod inputs;
mod roles;
mod round_trips;

use std::{fs, io::Write, path::PathBuf, process::Command};

use image::{DynamicImage, GrayImage, Rgb, RgbImage, RgbaImage};
use serde_json::{Value, json};

/// A temporary folder of one test, which is removed when it is dropped.
struct Folder(PathBuf);

impl Folder {
    fn new(test: &str) -> Self {
        let name = format!("wavelet-tex-{test}-{}", std::process::id());
        let path = std::env::temp_dir().join(name);
        fs::create_dir_all(&path).expect("a temporary folder");
        Self(path)
    }

    /// The tool in the folder, with the arguments of a line that spaces separate.
    fn command(&self, line: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_wavelet-tex"));
        command.current_dir(&self.0).args(line.split_whitespace());
        command
    }

    /// Runs the tool and asserts that it did not panic.
    fn run(&self, line: &str) -> Ran {
        let output = self.command(line).output().expect("the tool starts");
        let ran = Ran {
            code: output.status.code(),
            text: String::from_utf8(output.stdout).expect("UTF-8"),
            errors: String::from_utf8_lossy(&output.stderr).into(),
        };
        assert!(!ran.errors.contains("panicked"), "{line}: {ran:?}");
        ran
    }

    /// Runs the tool, which must succeed, and returns its standard output.
    fn ok(&self, line: &str) -> String {
        let ran = self.run(line);
        assert_eq!(ran.code, Some(0), "{line}: {ran:?}");
        ran.text
    }

    fn json(&self, line: &str) -> Value {
        serde_json::from_str(&self.ok(line)).expect("JSON")
    }

    /// Returns the output of `info` for a texture.
    fn info(&self, name: &str) -> Value {
        self.json(&format!("info {name} --json"))
    }

    /// Runs the tool, which must fail with this exit code, write these words to standard error, and
    /// leave the folder as it was.
    fn fails(&self, code: i32, line: &str, words: &[&str]) {
        let before = self.contents();
        let ran = self.run(line);
        assert_eq!(ran.code, Some(code), "{line}: {ran:?}");
        words.iter().for_each(|words| ran.says(words));
        assert_eq!(self.contents(), before, "{line}");
    }

    /// Returns the names and lengths of all files.
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

    /// Saves a PNG, and makes its folder.
    fn save(&self, name: &str, image: impl Into<DynamicImage>) {
        image.into().save(self.made(name)).expect("a PNG");
    }

    /// Writes a file, and makes its folder.
    fn write(&self, name: &str, bytes: &[u8]) {
        fs::write(self.made(name), bytes).expect("a file");
    }

    fn made(&self, name: &str) -> PathBuf {
        let path = self.0.join(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("made");
        path
    }

    fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.0.join(name)).expect("a file")
    }

    /// The bytes of a texture without the fingerprint of what it was made of.
    fn texture(&self, name: &str) -> Vec<u8> {
        let mut bytes = self.read(name);
        assert_eq!(bytes[9] & 2, 2, "{name} has a fingerprint");
        bytes[9] &= !2;
        bytes.truncate(bytes.len() - 8);
        bytes
    }

    /// The pixels of a level of a texture.
    fn level(&self, name: &str, level: u32) -> RgbaImage {
        self.ok(&format!("decode {name} level.png --level {level}"));
        self.open("level.png").into_rgba8()
    }

    fn open(&self, name: &str) -> DynamicImage {
        image::open(self.0.join(name)).expect("a PNG")
    }

    fn psnr(&self, a: &str, b: &str) -> f64 {
        let difference = self.json(&format!("compare {a} {b} --json"));
        match &difference["psnr_db"] {
            Value::Null => f64::INFINITY,
            number => number.as_f64().expect("a number"),
        }
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// What a run has written.
#[derive(Debug)]
struct Ran {
    code: Option<i32>,
    text: String,
    /// Errors and warnings.
    errors: String,
}

impl Ran {
    /// Asserts that these words are in the errors and warnings.
    fn says(&self, words: &str) {
        assert!(self.errors.contains(words), "no {words:?} in {self:?}");
    }

    fn json(&self) -> Value {
        serde_json::from_str(&self.text).expect("JSON")
    }
}

/// A glTF file with these materials, an image of each URI, and a texture of each image.
fn gltf(materials: Value, uris: &[&str]) -> Vec<u8> {
    let images: Vec<Value> = uris.iter().map(|uri| json!({"uri": uri})).collect();
    let textures = (0..uris.len()).map(|source| json!({"source": source}));
    let json = json!({
        "asset": {"version": "2.0"},
        "images": images,
        "textures": textures.collect::<Vec<_>>(),
        "materials": materials,
    });
    json.to_string().into_bytes()
}

/// An image of smooth colours with a few edges, whose size is not a multiple of a block.
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

/// The normals of a bump map.
fn normal_image() -> RgbImage {
    RgbImage::from_fn(64, 64, |x, y| {
        let (dx, dy) = ((x as f32 * 0.2).cos() * 0.5, (y as f32 * 0.15).sin() * 0.5);
        let length = (dx * dx + dy * dy + 1.0).sqrt();
        Rgb([-dx, -dy, 1.0].map(|v| (127.5 + 127.5 * v / length).round() as u8))
    })
}

/// Reports a part of a test that is left out. `scripts/test` prints at its end what it finds in the file that
/// `SKIPPED_TESTS` names.
fn skipped(what: &str) {
    println!("skipped: {what}");
    if let Some(path) = std::env::var_os("SKIPPED_TESTS") {
        let file = fs::OpenOptions::new().create(true).append(true).open(path);
        file.and_then(|mut file| writeln!(file, "{what}"))
            .expect("the file that SKIPPED_TESTS names");
    }
}

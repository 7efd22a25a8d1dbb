//! The studies of a folder with one image, and of a model with one material.

use std::path::{Path, PathBuf};

use bevy_wavelet_tex::{codec::settings::EncodeSettings, file};
use image::{DynamicImage, ImageFormat, RgbImage};

use super::{encoded::encoded, *};
use crate::content;

/// A temporary folder of one test, which is removed when it is dropped.
struct Folder(PathBuf);

impl Folder {
    fn new(test: &str) -> Self {
        let name = format!("wavelet-given-{test}-{}", std::process::id());
        let path = std::env::temp_dir().join(name);
        std::fs::create_dir_all(&path).expect("a temporary folder");
        Self(path)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn photo() -> RgbImage {
    content::photo_like(75, 46, 7)
}

/// The table that a command line asks for.
fn table(words: &[&str], path: &Path) -> Result<String, TradeoffError> {
    assert!(is_word(OsStr::new(words[0])));
    let words = ["tradeoff wavelet_tex"].iter().chain(words).map(OsStr::new);
    let words = words.chain([path.as_os_str()]);
    Options::try_parse_from(words)
        .expect("a command line")
        .table()
}

/// Returns the numbers in the cells of a row.
fn figures(table: &str, name: &str) -> Vec<f64> {
    let start = format!("| {name} |");
    let line = table.lines().find(|line| line.starts_with(&start));
    let line = line.unwrap_or_else(|| panic!("no {name}: {table}"));
    let cells = line[start.len()..].split('|');
    cells.filter_map(|cell| cell.trim().parse().ok()).collect()
}

#[test]
fn images_are_measured_beside_block_formats() {
    let folder = Folder::new("rivals");
    photo().save(folder.0.join("one.png")).expect("a PNG");
    let text = table(&["rivals"], &folder.0).expect("a table");
    for (table, rate) in text.split("\n\n").zip(rivals::RATES) {
        assert!(table.starts_with(&format!("| {} |", rate.name())), "{text}");
        let row = figures(table, "one");
        let [here, wavelet, bc1, scaled, bc7] = *row else {
            panic!("{text}");
        };
        assert!(here >= wavelet && wavelet > 20.0, "{text}");
        assert!(bc7 > bc1 && bc7 > scaled && here > scaled, "{text}");
        assert_eq!(figures(table, "mean"), row, "{text}");
        assert_eq!(figures(table, "least above")[0], 0.0, "{text}");
    }
    let missing = folder.0.join("missing.png");
    let error = table(&["rivals"], &missing).expect_err("no such file");
    assert!(error.to_string().contains("missing.png"), "{error}");
}

#[test]
fn files_are_counted_with_their_bytes() {
    let folder = Folder::new("sizes");
    let (texture, _) = encoded(&photo().into(), &EncodeSettings::default()).expect("a texture");
    let bytes = file::write(&texture);
    for name in ["a.wtex", "b.wtex", "c.txt"] {
        std::fs::write(folder.0.join(name), &bytes).expect("a file");
    }
    let text = table(&["sizes"], &folder.0).expect("a table");
    let row = figures(&text, &folder.0.display().to_string());
    assert_eq!(row[..2], [2.0, bytes.len() as f64], "{text}");
    assert_eq!(row.len(), 3, "{text}");
}

#[test]
fn the_bits_of_a_material_are_those_of_its_maps() {
    let folder = Folder::new("materials");
    let color = DynamicImage::from(photo());
    let mut buffer = std::io::Cursor::new(Vec::new());
    let written = color.write_to(&mut buffer, ImageFormat::Png);
    written.expect("a PNG in a buffer");
    let buffer = buffer.into_inner();
    std::fs::write(folder.0.join("buffer.bin"), &buffer).expect("a file");
    let normal = content::bricks(64, 64, 7).normal;
    normal.save(folder.0.join("normal.png")).expect("a PNG");
    let gray = DynamicImage::from(color.to_luma8());
    gray.save(folder.0.join("gray.png")).expect("a PNG");
    let model = serde_json::json!({
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": buffer.len(), "uri": "buffer.bin"}],
        "bufferViews": [{"buffer": 0, "byteLength": buffer.len()}],
        "images": [
            {"bufferView": 0, "mimeType": "image/png"},
            {"uri": "normal.png"},
            {"uri": "gray.png"},
        ],
        "textures": [{"source": 0}, {"source": 1}, {"source": 2}],
        "materials": [{"name": "plain"}, {
            "name": "wall",
            "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}},
            "normalTexture": {"index": 1},
            "occlusionTexture": {"index": 2},
        }],
    });
    let path = folder.0.join("model.gltf");
    std::fs::write(&path, model.to_string()).expect("a model");
    let text = table(&["materials"], &path).expect("a table");
    assert!(!text.contains("plain"), "{text}");
    let [bpp, lit, bc1_bpp, bc1_lit, bc7_bpp, bc7_lit] = *figures(&text, "wall") else {
        panic!("{text}");
    };
    // The maps are of two sizes, so the bits are those of both for each pixel of 75 x 64.
    let (photo, normals, all) = (75.0 * 46.0, 64.0 * 64.0, 75.0 * 64.0);
    let blocks = f64::from(19 * 12 * 16 * 8);
    let expected = (blocks + 8.0 * normals + blocks / 2.0) / all;
    assert!((bc7_bpp - expected).abs() < 0.01, "{expected}: {text}");
    let least = (3.0 * photo + 4.0 * normals + 2.0 * photo) / all;
    assert!((least..1.2 * least).contains(&bpp), "{least}: {text}");
    assert!(bc7_bpp > bc1_bpp && bc1_bpp > bpp, "{text}");
    assert!(20.0 < lit && lit < bc7_lit && bc1_lit < bc7_lit, "{text}");

    std::fs::write(folder.0.join("buffer.bin"), &buffer[..40]).expect("a file");
    let error = table(&["materials"], &path).expect_err("a short buffer");
    assert!(error.to_string().contains("cut short"), "{error}");
}

//! Tests of images inside glTF files.

use image::ImageFormat;

use crate::support::{Folder, color_image, gray_image, normal_image, stderr};

#[test]
fn images_inside_gltf_files_are_encoded_by_their_role() {
    let f = Folder::new("gltf");
    let mut binary = Vec::new();
    let mut views = Vec::new();
    for (image, format) in [
        (color_image(), ImageFormat::Jpeg),
        (normal_image(), ImageFormat::Png),
    ] {
        let mut file = std::io::Cursor::new(Vec::new());
        image.write_to(&mut file, format).expect("an image");
        let file = file.into_inner();
        views.push(serde_json::json!({
            "buffer": 0, "byteOffset": binary.len(), "byteLength": file.len()
        }));
        binary.extend(file);
    }
    f.save("apart.png", gray_image());
    let json = serde_json::json!({
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": binary.len()}],
        "bufferViews": views,
        "images": [
            {"bufferView": 0, "mimeType": "image/jpeg"},
            {"bufferView": 1, "mimeType": "image/png"},
            {"uri": "apart.png"},
            {"uri": "unused.png"},
        ],
        "textures": [{"source": 0}, {"source": 1}, {"source": 2}, {"source": 3}],
        "materials": [{
            "name": "wall",
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
    let rows = f.json(&["encode", "model.glb", "--effort", "fast", "--json"]);
    assert_eq!(rows.as_array().map(Vec::len), Some(3));
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

#[test]
fn a_file_without_maps_is_named_and_stops_no_other() {
    let f = Folder::new("no-maps");
    f.save("a.png", color_image());
    f.write(
        "plain.gltf",
        br#"{"asset": {"version": "2.0"}, "materials": [{"name": "gray"}]}"#,
    );
    f.fails(1, &["encode", "plain.gltf"], &["no material has a map"]);
    let output = f.run(&["encode", "plain.gltf", "a.png"]);
    assert!(output.status.success() && f.0.join("a.wtex").exists());
    let warnings = stderr(&output);
    assert!(
        warnings.contains("plain.gltf: no material has a map"),
        "{warnings}"
    );
}

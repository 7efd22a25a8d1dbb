//! Tests of what images are encoded as: their roles, their alpha and their rates, by themselves and inside glTF files.
//! What nobody sees of transparent parts costs nothing and shows nowhere, and what is cut out keeps its size.

use image::{GrayAlphaImage, GrayImage, ImageFormat, Luma, LumaA, Rgb, RgbImage, Rgba, RgbaImage};
use serde_json::{Value, json};

use crate::{Folder, color_image, gltf, gray_image, normal_image};

fn row(f: &Folder, line: &str) -> Value {
    f.json(&format!("encode {line} --json --effort fast"))[0].clone()
}

#[test]
fn masks_and_occlusion_are_one_channel() {
    let f = Folder::new("channel");
    f.save("a.png", RgbImage::from_pixel(64, 64, Rgb([255, 128, 0])));
    for role in ["mask", "occlusion"] {
        let row = row(&f, &format!("a.png a.wtex --role {role}"));
        assert_eq!(row["channel"], "red", "{row}");
        assert_eq!(row["psnr_db"], Value::Null, "{row}");
        assert!(f.level("a.wtex", 0).pixels().all(|p| p[0] == 255), "{role}");
    }
    let shape = |x: u32| if x < 20 { 255 } else { 0 };
    f.save(
        "b.png",
        RgbaImage::from_fn(64, 64, |x, _| Rgba([7, 90, 12, shape(x)])),
    );
    let row = row(&f, "b.png b.wtex --role mask");
    assert_eq!(row["channel"], "alpha", "{row}");
    let level = f.level("b.wtex", 0);
    assert!(level.get_pixel(5, 5)[0] > 250 && level.get_pixel(40, 5)[0] < 5);
    let line = f.ok("encode b.png b.wtex --role mask --force");
    assert!(line.contains("mask of alpha"), "{line}");
}

#[test]
fn an_image_in_two_roles_serves_both_or_becomes_two() {
    let f = Folder::new("two-roles");
    let orm = RgbImage::from_fn(64, 64, |x, y| Rgb([(3 * x) as u8, (4 * y) as u8, 255]));
    f.save("orm.png", orm);
    f.save("wall.png", normal_image());
    // The order of textures does not matter.
    for (occlusion, rest) in [(0, 1), (1, 0)] {
        let material = json!([{
            "occlusionTexture": {"index": occlusion},
            "pbrMetallicRoughness": {"metallicRoughnessTexture": {"index": rest}},
        }]);
        f.write("a.gltf", &gltf(material, &["orm.png", "orm.png"]));
        let row = row(&f, "a.gltf --force");
        assert_eq!(row["role"], "data", "{row}");
        let info = f.info("orm.wtex");
        assert_eq!(
            (&info["content"], &info["color_space"]),
            (&json!("color"), &json!("linear"))
        );
    }
    let material = json!([{
        "normalTexture": {"index": 0},
        "pbrMetallicRoughness": {"baseColorTexture": {"index": 1}},
        "emissiveTexture": {"index": 1},
    }]);
    f.write("b.gltf", &gltf(material, &["wall.png", "wall.png"]));
    f.ok("encode b.gltf --effort fast");
    let content = |name: &str| f.info(name)["content"].clone();
    assert_eq!(content("wall.wtex"), "color");
    assert_eq!(content("wall.normal.wtex"), "normal");
}

#[test]
fn names_tell_roles() {
    let f = Folder::new("names");
    for name in ["wall", "wall_orm", "wall_ao", "wall_detail", "photo_n"] {
        f.save(&format!("set/{name}.png"), color_image());
    }
    f.save("set/wall_n.png", normal_image());
    f.write("roles", b"# of this game\n*_detail.png data\n");
    let ran = f.run("encode set --roles roles --effort fast");
    assert_eq!(ran.code, Some(0), "{ran:?}");
    ran.says("photo_n.png: its name is that of a normal map");
    for (name, content, space) in [
        ("wall", "color", "srgb"),
        ("wall_n", "normal", "linear"),
        ("wall_orm", "color", "linear"),
        ("wall_ao", "gray", "linear"),
        ("wall_detail", "color", "linear"),
        ("photo_n", "color", "srgb"),
    ] {
        let info = f.info(&format!("set/{name}.wtex"));
        assert_eq!(
            (&info["content"], &info["color_space"]),
            (&json!(content), &json!(space)),
            "{name}"
        );
    }
    let row = row(&f, "set/wall_n.png --role color");
    assert_eq!(row["content"], "color");
    f.write("bad", b"*_x.png depth\n");
    f.fails(
        1,
        "encode set --roles bad",
        &["bad: line 1", "depth is no role", "occlusion"],
    );
}

#[test]
fn alpha_is_kept_where_it_is_needed_and_only_there() {
    let f = Folder::new("needed");
    f.save(
        "la.png",
        GrayAlphaImage::from_pixel(64, 64, LumaA([90, 40])),
    );
    for line in ["la.png --force", "la.png --force --alpha"] {
        let row = row(&f, line);
        assert_eq!(row["content"], "color_alpha", "{row}");
        assert!(
            f.level("la.wtex", 0)
                .pixels()
                .all(|p| p.0 == [90, 90, 90, 40])
        );
    }
    let half = |x: u32| if x < 32 { 255 } else { 90 };
    f.save(
        "half.png",
        RgbaImage::from_fn(64, 64, |x, y| Rgba([x as u8, y as u8, 9, half(x)])),
    );
    f.save(
        "full.png",
        RgbaImage::from_fn(64, 64, |x, y| Rgba([x as u8, y as u8, 9, 255])),
    );
    let content = |line: &str| row(&f, line)["content"].clone();
    assert_eq!(content("full.png --alpha"), "color");
    assert_eq!(content("half.png --role data --alpha"), "color");
    for (mode, expected) in [
        ("OPAQUE", "color"),
        ("BLEND", "color_alpha"),
        ("MASK", "color_alpha"),
    ] {
        let material = json!([{
            "alphaMode": mode,
            "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}},
        }]);
        f.write("a.gltf", &gltf(material, &["half.png"]));
        assert_eq!(content("a.gltf"), expected, "{mode}");
    }
    let material = json!([{"alphaMode": "BLEND", "emissiveTexture": {"index": 0}}]);
    f.write("a.gltf", &gltf(material, &["half.png"]));
    assert_eq!(content("a.gltf"), "color");
}

#[test]
fn bits_mean_a_rate_of_the_content() {
    let f = Folder::new("bits");
    f.save("photo.png", color_image());
    f.save("gray.png", gray_image());
    f.save("bumps.png", normal_image());
    let content = |line: &str| row(&f, line)["content"].clone();
    assert_eq!(content("photo.png --rate 4"), "color");
    assert_eq!(content("gray.png --rate 4"), "gray");
    assert_eq!(content("bumps.png --rate 4 --role normal"), "normal");
    f.fails(
        2,
        "encode photo.png new.wtex --rate 2",
        &["color cannot", "color2.25"],
    );
    // A rate is for the images of its kind.
    let material = json!([{
        "normalTexture": {"index": 1},
        "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}},
    }]);
    f.write("a.gltf", &gltf(material, &["photo.png", "bumps.png"]));
    for (rate, bits) in [("color5", [5.0, 4.0]), ("color5,normal8", [5.0, 8.0])] {
        let rows = f.json(&format!(
            "encode a.gltf --rate {rate} --effort fast --json --formats wavelet"
        ));
        let info = |name| f.info(name)["content"].clone();
        assert_eq!(
            (info("photo.wtex"), info("bumps.wtex")),
            (json!("color"), json!("normal"))
        );
        let bpp = [0, 1].map(|i: usize| rows[i]["bpp"].as_f64().expect("bits"));
        assert!(
            bpp[0] > 4.9 && bpp[0] < 6.5 && bpp[1] >= 4.0,
            "{bits:?}: {bpp:?}"
        );
    }
}

#[test]
fn maps_that_stay_as_they_are_are_named() {
    let f = Folder::new("left");
    f.save("photo.png", color_image());
    let coat = json!({"KHR_materials_clearcoat": {"clearcoatTexture": {"index": 0}}});
    f.write(
        "a.gltf",
        &gltf(json!([{"extensions": coat}]), &["photo.png"]),
    );
    f.fails(
        1,
        "encode a.gltf",
        &["a.gltf", "nothing to encode", "KHR_materials_clearcoat"],
    );
    let both = json!([{
        "extensions": coat,
        "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}},
    }]);
    f.write("b.gltf", &gltf(both, &["photo.png"]));
    let ran = f.run("encode b.gltf --effort fast");
    assert_eq!(ran.code, Some(0));
    ran.says("KHR_materials_clearcoat keep their own");
}

#[test]
fn alpha_and_16_bits_count_in_comparisons() {
    let f = Folder::new("compared");
    f.save("rgb.png", color_image());
    f.save(
        "rgba.png",
        RgbaImage::from_fn(75, 46, |x, y| {
            let [r, g, b] = color_image().get_pixel(x, y).0;
            Rgba([r, g, b, if x < 37 { 0 } else { 255 }])
        }),
    );
    assert!(f.psnr("rgb.png", "rgba.png") < 20.0);
    assert_eq!(f.psnr("rgba.png", "rgba.png"), f64::INFINITY);
    let wide = |low: u16| {
        let image =
            image::ImageBuffer::<Luma<u16>, Vec<u16>>::from_pixel(8, 8, Luma([0x4000 + low]));
        image::DynamicImage::ImageLuma16(image)
    };
    f.save("wide.png", wide(0));
    f.save("other.png", wide(60));
    assert!(f.psnr("wide.png", "other.png").is_finite());
    // What nobody sees has no error.
    let clear = |r: u8| RgbaImage::from_pixel(8, 8, Rgba([r, 0, 0, 0]));
    f.save("clear.png", clear(0));
    f.save("red.png", clear(255));
    assert_eq!(f.psnr("clear.png", "red.png"), f64::INFINITY);
}

#[test]
fn what_files_say_in_vain_is_a_warning() {
    let f = Folder::new("said");
    let mut png = Vec::new();
    let mut encoder = png::Encoder::new(&mut png, 4, 4);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_source_gamma(png::ScaledFloat::new(1.0));
    let mut writer = encoder.write_header().expect("a header");
    writer.write_image_data(&[90; 16]).expect("pixels");
    writer.finish().expect("an end");
    f.write("gamma.png", &png);
    f.run("encode gamma.png").says("gAMA chunk says 1.000");
    f.save("usual.png", GrayImage::new(4, 4));
    assert_eq!(f.run("encode usual.png").errors, "");

    let mut ktx2 = crate::inputs::ktx2(ktx2::Format::R8_UNORM, [4, 4], &[90; 16], false);
    // The flags of the descriptor, then a key at the end of the file.
    ktx2[80 + 24 + 15] |= 1;
    let start = ktx2.len() as u32;
    let entry = b"KTXorientation\0ru\0";
    ktx2.extend((entry.len() as u32).to_le_bytes());
    ktx2.extend(entry);
    let length = ktx2.len() as u32 - start;
    ktx2[56..60].copy_from_slice(&start.to_le_bytes());
    ktx2[60..64].copy_from_slice(&length.to_le_bytes());
    f.write("said.ktx2", &ktx2);
    let ran = f.run("encode said.ktx2");
    ran.says("KTXorientation is ru");
    ran.says("premultiplied");
}

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
        views.push(json!({
            "buffer": 0, "byteOffset": binary.len(), "byteLength": file.len()
        }));
        binary.extend(file);
    }
    f.save("apart.png", gray_image());
    let json = json!({
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
    let rows = f.json("encode model.glb --effort fast --json");
    assert_eq!(rows.as_array().map(Vec::len), Some(3));
    assert_eq!(f.info("model.glb.Texture0.wtex")["content"], "color");
    assert_eq!(f.info("model.glb.Texture1.wtex")["content"], "normal");
    assert_eq!(f.info("apart.wtex")["content"], "gray");
    assert_eq!(f.info("apart.wtex")["color_space"], "linear");

    f.write("short.glb", &glb[..40]);
    f.fails(1, "encode short.glb", &["short.glb", "cut short"]);
    f.write(
        "bad.gltf",
        br#"{"materials": [{"normalTexture": {"index": 7}}]}"#,
    );
    f.fails(1, "encode bad.gltf", &["bad.gltf", "texture 7"]);
}

#[test]
fn a_file_without_maps_is_named_and_stops_no_other() {
    let f = Folder::new("no-maps");
    f.save("a.png", color_image());
    f.write(
        "plain.gltf",
        br#"{"asset": {"version": "2.0"}, "materials": [{"name": "gray"}]}"#,
    );
    f.fails(1, "encode plain.gltf", &["no material has a map"]);
    let ran = f.run("encode plain.gltf a.png");
    assert!(ran.code == Some(0) && f.0.join("a.wtex").exists());
    ran.says("plain.gltf: no material has a map");
}

const SIZE: u32 = 256;

/// Thin leaves with soft edges, in several greens; `clear` is the colour where there are none.
fn leaves(clear: [u8; 3], edge: f32) -> RgbaImage {
    let leaf = |i: u32| {
        let random =
            |k: u32| ((i * 7 + k).wrapping_mul(2_654_435_761) >> 8) as f32 / (1 << 24) as f32;
        (
            random(0) * 256.0,
            random(1) * 256.0,
            random(2) * std::f32::consts::PI,
            random(3),
        )
    };
    let leaves: Vec<_> = (0..60).map(leaf).collect();
    RgbaImage::from_fn(SIZE, SIZE, |x, y| {
        let (mut alpha, mut shade) = (0.0, 0.0);
        for (cx, cy, angle, tone) in &leaves {
            let (dx, dy) = (x as f32 - cx, y as f32 - cy);
            let (along, across) = (
                dx * angle.cos() + dy * angle.sin(),
                dy * angle.cos() - dx * angle.sin(),
            );
            let inside = 1.0 - ((along / 22.0).powi(2) + (across / 3.5).powi(2)).sqrt();
            let own = (inside * edge + 0.5).clamp(0.0, 1.0);
            if own > alpha {
                (alpha, shade) = (own, 0.6 + 0.4 * tone + 0.1 * (along * 0.9).sin());
            }
        }
        if alpha == 0.0 {
            let [r, g, b] = clear;
            return Rgba([r, g, b, 0]);
        }
        let [r, g, b] = [50.0, 140.0, 36.0].map(|v: f32| (v * shade) as u8);
        Rgba([r, g, b, (alpha * 255.0).round() as u8])
    })
}

fn covered(image: &RgbaImage, cutoff: u8, channel: usize) -> f64 {
    let there = image.pixels().filter(|p| p[channel] >= cutoff).count();
    there as f64 / f64::from(image.width() * image.height())
}

/// Mean squared error of the colour where a picture is opaque.
fn opaque_error(a: &RgbaImage, b: &RgbaImage) -> f64 {
    let pairs = a.pixels().zip(b.pixels()).filter(|(a, _)| a[3] == 255);
    let error = |(a, b): (&Rgba<u8>, &Rgba<u8>)| {
        (0..3)
            .map(|c| (f64::from(a[c]) - f64::from(b[c])).powi(2))
            .sum::<f64>()
    };
    let errors: Vec<f64> = pairs.map(error).collect();
    errors.iter().sum::<f64>() / (3 * errors.len()) as f64
}

#[test]
fn a_cut_out_keeps_its_area_in_every_mip() {
    let f = Folder::new("coverage");
    let image = leaves([255, 0, 255], 4.0);
    f.save("leaves.png", image.clone());
    f.save("hard.png", leaves([255, 0, 255], 1000.0));
    let shape: Vec<u8> = image.pixels().map(|p| p[3]).collect();
    let mask = GrayImage::from_raw(SIZE, SIZE, shape).expect("a mask");
    f.save("mask.png", mask);
    for (name, options, channel, cutoff) in [
        ("leaves", "", 3, 0.5),
        ("hard", "", 3, 0.5),
        ("leaves", "--cutoff 0.3", 3, 0.3),
        ("mask", "--role mask", 0, 0.5),
    ] {
        let png = format!("{name}.png");
        let row = f.json(&format!("encode {png} a.wtex --json {options}"));
        let levels = row[0]["levels"].as_u64().expect("a number") as u32;
        let cutoff = (cutoff * 255.0_f64).ceil() as u8;
        let original = f.open(&png).into_rgba8();
        let expected = covered(&original, cutoff, channel);
        assert!((0.1..0.4).contains(&expected), "{expected}");
        for level in 0..levels {
            let decoded = f.level("a.wtex", level);
            let actual = covered(&decoded, cutoff, channel);
            // No more than one pixel in a hundred, or what whole pixels allow.
            let pixels = f64::from(decoded.width() * decoded.height());
            let most = (0.5 / pixels).max(0.01) + 1e-9;
            assert!(
                (actual - expected).abs() <= most,
                "{name} {options}, level {level}: {actual} for {expected}"
            );
        }
    }
    f.ok("encode leaves.png a.wtex --cutoff none");
    // Filtered alpha has none of what is thinner than a pixel.
    let actual = covered(&f.level("a.wtex", 6), 128, 3);
    assert_eq!(actual, 0.0);
}

#[test]
fn colours_that_nobody_sees_cost_nothing() {
    let f = Folder::new("unseen");
    let image = leaves([255, 0, 255], 4.0);
    f.save("magenta.png", image.clone());
    f.save("like.png", leaves([44, 125, 31], 4.0));
    let error = |name: &str| {
        f.ok(&format!("encode {name} a.wtex"));
        let decoded = f.level("a.wtex", 0);
        opaque_error(&image, &decoded)
    };
    let [magenta, like] = ["magenta.png", "like.png"].map(error);
    assert!(magenta < 1.3 * like, "{magenta} for {like}");
    // 16 bits are filled, too.
    f.save(
        "wide.png",
        image::DynamicImage::from(image.clone()).into_rgba16(),
    );
    let wide = error("wide.png");
    assert!(wide < 1.3 * like, "{wide} for {like}");
}

#[test]
fn no_mip_has_the_colour_of_what_nobody_sees() {
    let f = Folder::new("edges");
    // Green rectangles of odd sizes on transparent magenta.
    f.save(
        "a.png",
        RgbaImage::from_fn(SIZE, SIZE, |x, y| match (x * 5 / 64 % 3, y * 3 / 64 % 2) {
            (1, 1) => Rgba([39, 109, 30, 255]),
            _ => Rgba([255, 0, 255, 0]),
        }),
    );
    f.ok("encode a.png --rate 8");
    for level in 0..8 {
        let decoded = f.level("a.wtex", level);
        for (x, y, p) in decoded.enumerate_pixels() {
            let far = [39, 109, 30]
                .iter()
                .zip(p.0)
                .map(|(a, b): (&u8, u8)| a.abs_diff(b));
            assert!(far.max() < Some(14), "level {level}, {x}, {y}: {p:?}");
        }
    }
}

//! Tests of the image formats that the tool reads, and that errors name their cause and overwrite no file.

use std::{fs, io::Cursor};

use image::{DynamicImage, GrayImage, ImageFormat, RgbImage, codecs::jpeg::JpegEncoder};
use ktx2::{Format, Header, Index, LevelIndex, SupercompressionScheme, dfd};
use ruzstd::encoding::{CompressionLevel, compress_to_vec};

use crate::{Folder, color_image, gray_image, normal_image};

/// Encodes a file and returns the texture.
fn encoded(f: &Folder, file: &str, options: &str) -> Vec<u8> {
    f.ok(&format!("encode {file} out.wtex --effort fast {options}"));
    f.texture("out.wtex")
}

fn file_of(image: &DynamicImage, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, format).expect("an image");
    bytes.into_inner()
}

/// A KTX2 file of one level.
pub fn ktx2(format: Format, size: [u32; 2], texels: &[u8], zstd: bool) -> Vec<u8> {
    let (basic, type_size) =
        dfd::Basic::from_format_with(format, false, None, None, None).expect("a simple format");
    let block = dfd::Block::Basic(basic).to_vec();
    let data = match zstd {
        true => compress_to_vec(texels, CompressionLevel::Fastest),
        false => texels.to_vec(),
    };
    let dfd_start = Header::LENGTH + LevelIndex::LENGTH;
    let data_start = (dfd_start + 4 + block.len()).next_multiple_of(16);
    let header = Header {
        format: Some(format),
        type_size,
        pixel_width: size[0],
        pixel_height: size[1],
        pixel_depth: 0,
        layer_count: 0,
        face_count: 1,
        level_count: 1,
        supercompression_scheme: zstd.then_some(SupercompressionScheme::Zstandard),
        index: Index {
            dfd_byte_offset: dfd_start as u32,
            dfd_byte_length: 4 + block.len() as u32,
            kvd_byte_offset: 0,
            kvd_byte_length: 0,
            sgd_byte_offset: 0,
            sgd_byte_length: 0,
        },
    };
    let level = LevelIndex {
        byte_offset: data_start as u64,
        byte_length: data.len() as u64,
        uncompressed_byte_length: texels.len() as u64,
    };
    let mut bytes = header.as_bytes().to_vec();
    bytes.extend(level.as_bytes());
    bytes.extend((4 + block.len() as u32).to_le_bytes());
    bytes.extend(block);
    bytes.resize(data_start, 0);
    bytes.extend(data);
    bytes
}

#[test]
fn every_format_gives_the_texture_of_its_pixels() {
    let f = Folder::new("formats");
    let rgba = DynamicImage::from(color_image()).into_rgba8();
    let images: [DynamicImage; 3] = [color_image().into(), gray_image().into(), rgba.into()];
    for image in images {
        f.save("in.png", image.clone());
        let expected = encoded(&f, "in.png", "");
        f.write("in.tga", &file_of(&image, ImageFormat::Tga));
        let color = image.color();
        assert_eq!(encoded(&f, "in.tga", ""), expected, "TGA {color:?}");
        // WebP has no gray.
        if color.has_color() {
            f.write("in.webp", &file_of(&image, ImageFormat::WebP));
            assert_eq!(encoded(&f, "in.webp", ""), expected, "WebP {color:?}");
        }
    }
    for image in [DynamicImage::from(color_image()), gray_image().into()] {
        let mut jpeg = Vec::new();
        let encoder = JpegEncoder::new_with_quality(&mut jpeg, 90);
        image.write_with_encoder(encoder).expect("a JPEG");
        // A wrong extension does not matter.
        f.write("in.webp", &jpeg);
        let decoded = image::load_from_memory(&jpeg).expect("a JPEG");
        assert_eq!(decoded.color(), image.color());
        f.save("in.png", decoded);
        assert_eq!(encoded(&f, "in.webp", ""), encoded(&f, "in.png", ""));
    }
    let compared = f.json("compare in.webp in.png --json");
    assert_eq!(compared["mse"], 0.0);
    let rows = f.json("bench in.webp in.tga --rates gray2 --effort fast --json");
    assert_eq!(rows.as_array().map(Vec::len), Some(2));
}

#[test]
fn ktx2_of_8_bits_is_read_in_its_color_space() {
    let f = Folder::new("ktx2");
    let color = DynamicImage::from(color_image());
    let size = [color.width(), color.height()];
    for zstd in [false, true] {
        for (image, srgb, linear) in [
            (color.clone(), Format::R8G8B8_SRGB, Format::R8G8B8_UNORM),
            (
                color.to_rgba8().into(),
                Format::R8G8B8A8_SRGB,
                Format::R8G8B8A8_UNORM,
            ),
            (gray_image().into(), Format::R8_SRGB, Format::R8_UNORM),
        ] {
            f.save("in.png", image.clone());
            f.write("in.ktx2", &ktx2(srgb, size, image.as_bytes(), zstd));
            assert_eq!(encoded(&f, "in.ktx2", ""), encoded(&f, "in.png", ""));
            f.write("in.ktx2", &ktx2(linear, size, image.as_bytes(), zstd));
            assert_eq!(
                encoded(&f, "in.ktx2", ""),
                encoded(&f, "in.png", "--linear")
            );
        }
    }
}

#[test]
fn two_channels_are_normals_by_their_role() {
    let f = Folder::new("red-green");
    let normals = normal_image();
    f.save("in.png", normals.clone());
    let pairs: Vec<u8> = normals.pixels().flat_map(|p| [p.0[0], p.0[1]]).collect();
    let size = normals.dimensions().into();
    f.write("in.ktx2", &ktx2(Format::R8G8_UNORM, size, &pairs, true));
    f.ok("encode in.ktx2 out.wtex --role normal");
    let difference = f.json("compare in.png out.wtex --json");
    let angle = difference["mean_angle_degrees"].as_f64().expect("normals");
    assert!(angle < 1.0, "{angle}");
    // Without the role it is a picture without blue.
    f.ok("encode in.ktx2 out.wtex");
    assert_eq!(f.info("out.wtex")["content"], "color");
}

#[test]
fn cut_files_are_named() {
    let f = Folder::new("cut");
    let image = DynamicImage::from(color_image());
    let size = [image.width(), image.height()];
    let plain = ktx2(Format::R8G8B8_UNORM, size, image.as_bytes(), false);
    let zstd = ktx2(Format::R8G8B8_UNORM, size, image.as_bytes(), true);
    for (name, words, bytes) in [
        ("a.jpg", "JPEG", file_of(&image, ImageFormat::Jpeg)),
        ("a.webp", "WebP", file_of(&image, ImageFormat::WebP)),
        ("a.tga", "TGA", file_of(&image, ImageFormat::Tga)),
        ("a.ktx2", "KTX2", plain),
        ("z.ktx2", "KTX2", zstd),
    ] {
        f.write(name, &bytes);
        f.ok(&format!("encode {name} good.wtex --effort fast"));
        for length in [bytes.len() / 2, 13] {
            f.write(name, &bytes[..length]);
            let words = [name, words, "cannot be decoded"];
            f.fails(1, &format!("encode {name} new.wtex"), &words);
        }
    }
}

#[test]
fn refused_files_are_named_with_the_remedy() {
    let f = Folder::new("refused");
    let fails = |name: &str, bytes: &[u8], words: &str| {
        f.write(name, bytes);
        f.fails(1, &format!("encode {name} new.wtex"), &[name, words]);
    };
    let blocks = ktx2(Format::BC7_SRGB_BLOCK, [4, 4], &[0; 16], false);
    fails(
        "bc7.ktx2",
        &blocks,
        "BC7_SRGB_BLOCK is block-compressed: encode the original",
    );
    let half = ktx2(Format::R16G16B16A16_SFLOAT, [1, 1], &[0; 8], false);
    fails("half.ktx2", &half, "convert it to 8 bits a channel");
    let good = ktx2(Format::R8_UNORM, [2, 2], &[9; 4], true);
    let with = |at: usize, value: u32| {
        let mut bytes = good.clone();
        bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
        bytes
    };
    fails("basis.ktx2", &with(12, 0), "Basis Universal");
    fails("cube.ktx2", &with(36, 6), "a cube");
    fails("zlib.ktx2", &with(44, 3), "write it with Zstandard");
    fails("wide.ktx2", &with(20, 20000), "20000 x 2");
    fails(
        "more.ktx2",
        &with(20, 16000),
        "has 4 bytes instead of 32000",
    );
    fails("fewer.ktx2", &with(24, 1), "more than 2 bytes");
    fails("line.ktx2", &with(24, 0), "2 x 0");
    fails("level.ktx2", &with(80, u32::MAX), "cut short");

    // A header of 18 bytes that claims 20000 x 20000 pixels.
    let mut tga = file_of(&RgbImage::new(4, 4).into(), ImageFormat::Tga);
    tga[12..16].copy_from_slice(&[0x20, 0x4e, 0x20, 0x4e]);
    fails("wide.tga", &tga, "20000 x 20000");
    fails(
        "text.jpg",
        b"no image of any kind",
        "not a PNG, JPEG, WebP, TGA or KTX2",
    );
}

#[test]
fn bad_input_is_named() {
    let f = Folder::new("bad");
    f.save("good.png", color_image());
    f.save("small.png", GrayImage::new(8, 8));
    f.ok("encode good.png good.wtex");
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
        ("text", "not a PNG, JPEG, WebP, TGA or KTX2: convert"),
        ("good.wtex", "wavelet-tex decode"),
        ("short.png", "cannot be decoded"),
        ("signature.png", "cannot be decoded"),
        ("absurd.png", "2147483647 x 2147483647"),
        ("wide.png", "16385 x 1"),
    ] {
        f.fails(1, &format!("encode {file} new.wtex"), &[file, words]);
    }
    for (file, words) in [
        ("missing", "cannot be read"),
        ("empty", "the file is empty"),
        ("good.png", "not a wavelet texture"),
        ("short.wtex", "cut short"),
        ("newer.wtex", "version 9 is newer"),
    ] {
        f.fails(1, &format!("decode {file} new.png"), &[file, words]);
        f.fails(1, &format!("info {file}"), &[file, words]);
    }
    for (file, words) in [
        ("missing", "cannot be read"),
        ("empty", "the file is empty"),
        ("text", "not a PNG, JPEG, WebP, TGA or KTX2"),
        ("short.png", "cannot be decoded"),
        ("short.wtex", "cut short"),
        ("small.png", "only images of one size"),
    ] {
        f.fails(1, &format!("compare good.wtex {file}"), &[file, words]);
    }
    f.fails(
        1,
        "decode good.wtex new.png --level 40",
        &["good.wtex", "no level 40: its levels are 0 to"],
    );
}

#[test]
fn bad_usage_is_named() {
    let f = Folder::new("usage");
    f.save("in.png", color_image());
    f.fails(2, "encode", &["INPUT"]);
    f.fails(2, "encode in.png --rate 7", &["'7'", "color3"]);
    f.fails(2, "encode in.png --role depth", &["normal"]);
    f.fails(2, "encode in.png --effort all", &["best"]);
    f.fails(
        2,
        "encode in.png --role normal --rate 3",
        &["normal cannot be coded at 3", "normal4"],
    );
    f.fails(2, "encode in.png --rate auto", &["--min-psnr"]);
    f.fails(
        2,
        "encode in.png --rate color3 --min-psnr 40",
        &["leave --rate away"],
    );
    f.fails(2, "encode in.png --min-psnr many", &["in dB"]);
    f.fails(2, "encode in.png --out out.png", &["out.png", ".wtex"]);
    f.fails(2, "decode in.wtex out.jpg", &["out.jpg", ".png"]);
}

#[test]
fn outputs_never_cost_a_file() {
    let f = Folder::new("outputs");
    f.save("in.png", color_image());
    fs::create_dir(f.0.join("folder.wtex")).expect("a folder");
    // This is the same file by another name.
    fs::hard_link(f.0.join("in.png"), f.0.join("link.wtex")).expect("a link");
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("in.png", f.0.join("soft.wtex")).expect("a link");
        f.fails(1, "encode in.png soft.wtex", &["soft.wtex", "is the input"]);
    }
    f.fails(1, "encode in.png folder.wtex", &["is a directory"]);
    f.fails(
        1,
        "encode in.png no/out.wtex",
        &["no/out.wtex", "folder no"],
    );

    // A failure keeps the old file; success replaces it and leaves no other file.
    f.write("out.wtex", b"precious");
    f.write("text", b"not an image");
    f.fails(1, "encode text out.wtex --force", &["text"]);
    f.fails(1, "encode in.png out.wtex", &["out.wtex", "--force"]);
    assert_eq!(f.read("out.wtex"), b"precious");
    let before = f.contents().len();
    f.ok("encode in.png out.wtex --force");
    assert_ne!(f.read("out.wtex"), b"precious");
    assert_eq!(f.contents().len(), before);
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

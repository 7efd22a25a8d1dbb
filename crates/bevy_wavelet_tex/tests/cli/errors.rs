//! Tests that errors name their cause, and that they overwrite no file.

use std::fs;

use image::GrayImage;

use crate::support::{Folder, color_image};

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
        ("text", "not a PNG, JPEG, WebP, TGA or KTX2: convert"),
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
        ("text", "not a PNG, JPEG, WebP, TGA or KTX2"),
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
    // This is the same file by another name.
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

    // A failure keeps the old file; success replaces it and leaves no other file.
    f.write("out.wtex", b"precious");
    f.write("text", b"not an image");
    f.fails(1, &["encode", "text", "out.wtex", "--force"], &["text"]);
    f.fails(
        1,
        &["encode", "in.png", "out.wtex"],
        &["out.wtex", "--force"],
    );
    assert_eq!(f.read("out.wtex"), b"precious");
    let before = f.contents().len();
    f.ok(&["encode", "in.png", "out.wtex", "--force"]);
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

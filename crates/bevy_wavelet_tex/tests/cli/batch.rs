//! Tests of several files at once: no file is lost, one bad file costs no other, nothing is done twice, and a required
//! quality and a number of threads hold for all.

use std::{fs, path::Path};

use serde_json::{Value, json};

use crate::{Folder, color_image, gltf, gray_image, normal_image, skipped};

#[test]
fn a_bad_file_in_a_batch_stops_no_other_and_is_named_at_the_end() {
    let f = Folder::new("batch");
    for name in ["a", "sub/b", "z"] {
        f.save(&format!("in/{name}.png"), gray_image());
    }
    f.write("in/m.png", b"no image");
    f.write("in/note.txt", b"not looked at");
    let ran = f.run("encode in --out out --json --effort fast");
    assert_eq!(ran.code, Some(1));
    ran.says("1 of 4 files failed");
    ran.says("in/m.png");
    assert!(!ran.errors.contains("note.txt"), "{ran:?}");
    let rows = ran.json();
    assert_eq!(rows.as_array().map(Vec::len), Some(3), "{rows}");
    for name in ["out/a.wtex", "out/sub/b.wtex", "out/z.wtex"] {
        assert!(f.0.join(name).is_file(), "{name}");
        assert!(rows.to_string().contains(name), "{name} in {rows}");
    }
    for row in rows.as_array().expect("rows") {
        assert!(row["psnr_db"].as_f64() > Some(30.0) && row["bpp"].as_f64() > Some(2.0));
    }

    f.ok("decode out --out back");
    assert!(f.psnr("in/sub/b.png", "back/sub/b.png") > 33.0);
    assert_eq!(f.json("info out --json").as_array().map(Vec::len), Some(3));
}

#[test]
fn globs_are_expanded_and_results_never_collide() {
    let f = Folder::new("glob");
    for name in ["a1.png", "a2.png", "b.png"] {
        f.save(name, gray_image());
    }
    let lines = f.ok("encode a?.png --effort fast");
    assert_eq!(lines.lines().count(), 3, "{lines}");
    assert!(lines.ends_with("2 files encoded\n"), "{lines}");
    assert!(f.0.join("a2.wtex").is_file() && !f.0.join("b.wtex").exists());
    f.fails(1, "encode c*.png", &["c*.png", "no file fits"]);
    fs::create_dir(f.0.join("empty")).expect("made");
    f.fails(1, "encode empty", &["empty", "no .png or .jpg"]);
    f.save("other/b.png", gray_image());
    let ran = f.run("encode b.png other/b.png --out all");
    assert_eq!(ran.code, Some(1));
    ran.says("is that of b.png");
    assert!(f.0.join("all/b.wtex").is_file());
}

#[test]
fn the_rate_follows_the_wanted_quality() {
    let f = Folder::new("auto");
    f.save("in.png", color_image());
    let mut last = 0.0;
    for min_psnr in ["20", "37", "40"] {
        let rows = f.json(&format!("encode in.png --min-psnr {min_psnr} --json"));
        let (bpp, psnr) = (rows[0]["bpp"].as_f64(), rows[0]["psnr_db"].as_f64());
        assert!(psnr >= min_psnr.parse().ok(), "{min_psnr}: {rows}");
        assert!(bpp >= Some(last), "{min_psnr}: {rows}");
        last = bpp.expect("a number");
    }
    assert!(last > 3.5, "{last}");
    let ran = f.run("encode in.png --rate auto --min-psnr 99");
    assert_eq!(ran.code, Some(0));
    ran.says("the largest rate reaches");
}

#[test]
fn the_result_does_not_depend_on_the_number_of_threads() {
    let f = Folder::new("threads");
    f.save("in.png", color_image());
    f.ok("encode in.png --threads 3");
    let mut results = vec![f.read("in.wtex")];
    for threads in ["1", "2", "5"] {
        let mut command = f.command("encode in.png --force");
        let output = command.env("RAYON_NUM_THREADS", threads).output();
        assert!(output.expect("the tool starts").status.success());
        results.push(f.read("in.wtex"));
    }
    assert!(results.windows(2).all(|pair| pair[0] == pair[1]));
}

/// Beside the threads that encode there are the main one and that of the progress bar.
#[test]
#[cfg(target_os = "linux")]
fn one_file_is_encoded_by_as_many_threads_as_asked_for() {
    let f = Folder::new("count");
    let color = |x: u32, y: u32| image::Rgb([(x * y % 251) as u8, (x ^ y) as u8, (x / 3) as u8]);
    f.save("in.png", image::RgbImage::from_fn(1024, 1024, color));
    for threads in [1, 3] {
        let mut command = f.command(&format!("encode in.png --force --threads {threads}"));
        let child = command.stdout(std::process::Stdio::null()).spawn();
        let mut child = child.expect("the tool starts");
        let folder = format!("/proc/{}/task", child.id());
        let mut most = 0;
        while child.try_wait().expect("a child").is_none() {
            most = most.max(fs::read_dir(&folder).map_or(0, Iterator::count));
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
        assert!(
            (threads + 1..=threads + 2).contains(&most),
            "{threads}: {most}"
        );
    }
}

#[test]
fn an_original_stays_when_its_texture_is_decoded() {
    let f = Folder::new("original");
    f.save("a.png", color_image());
    f.save("set/b.png", gray_image());
    let originals = [f.read("a.png"), f.read("set/b.png")];
    f.ok("encode a.png");
    f.ok("encode set");
    f.fails(1, "decode a.wtex", &["a.png", "did not write", "--force"]);
    f.fails(1, "decode set", &["b.png", "--force"]);
    assert_eq!([f.read("a.png"), f.read("set/b.png")], originals);
    // The tool replaces a file that it has decoded itself.
    f.ok("decode a.wtex back.png");
    f.ok("decode a.wtex back.png --level 1");
    f.ok("decode a.wtex --force");
    assert_ne!(f.read("a.png"), originals[0]);
}

#[test]
fn no_output_is_another_input_even_by_force() {
    let f = Folder::new("inputs");
    f.save("a.png", color_image());
    f.ok("encode a.png b.wtex");
    fs::copy(f.0.join("a.png"), f.0.join("a.wtex")).expect("a copy");
    f.fails(
        1,
        "encode a.png a.wtex --out . --force",
        &["a.wtex", "the output is the input"],
    );
}

#[test]
fn what_a_killed_run_left_stops_nothing() {
    let f = Folder::new("killed");
    f.save("a.png", gray_image());
    // The process number of the next run is not known, so all that it can be are there.
    for pid in 1..40000 {
        f.write(&format!(".wavelet-tex-{pid}.tmp"), b"half");
    }
    f.ok("encode a.png --effort fast");
}

#[test]
fn unchanged_images_are_not_encoded_again() {
    let f = Folder::new("unchanged");
    f.save("a.png", color_image());
    f.save("b.png", gray_image());
    let rows = |options: &str| {
        let rows = f.json(&format!(
            "encode a.png b.png --effort fast --json {options}"
        ));
        [0, 1].map(|i: usize| rows[i]["unchanged"].as_bool().expect("a row"))
    };
    assert_eq!(rows(""), [false, false]);
    let time = || fs::metadata(f.0.join("a.wtex")).and_then(|m| m.modified());
    let written = time().expect("a time");
    assert_eq!(rows(""), [true, true]);
    assert_eq!(time().expect("a time"), written);
    assert_eq!(rows("--no-mips"), [false, false]);
    assert_eq!(rows("--no-mips --force"), [false, false]);
    f.save("b.png", normal_image());
    assert_eq!(rows("--no-mips"), [true, false]);
    // A texture that was cut short is made again.
    let bytes = f.read("a.wtex");
    f.write("a.wtex", &bytes[..bytes.len() / 2]);
    assert_eq!(rows("--no-mips"), [false, true]);
    let text = f.ok("encode a.png b.png --effort fast --no-mips");
    assert!(
        text.contains("b.wtex") && text.contains(", unchanged"),
        "{text}"
    );
    assert!(text.ends_with("0 files encoded, 2 unchanged\n"), "{text}");
}

#[test]
#[cfg(unix)]
fn json_holds_names_that_are_not_text() {
    use std::{ffi::OsStr, os::unix::ffi::OsStrExt};
    let f = Folder::new("name");
    let name = OsStr::from_bytes(b"a\xff.png");
    gray_image()
        .save_with_format(f.0.join(name), image::ImageFormat::Png)
        .expect("a PNG");
    f.save("b.png", gray_image());
    let rows = f.json("encode . --json --effort fast");
    assert_eq!(rows.as_array().map(Vec::len), Some(2));
    let infos = f.json("info . --json");
    assert_eq!(infos.as_array().map(Vec::len), Some(2));
    f.json("bench . --rates gray2 --effort fast --json");
}

#[test]
fn a_batch_says_each_file_as_it_is_done_and_counts_them() {
    let f = Folder::new("streams");
    f.save("set/a.png", gray_image());
    f.write("set/b.png", b"no image");
    f.save("set/c.png", gray_image());
    let ran = f.run("encode set --effort fast");
    assert_eq!(ran.code, Some(1));
    let bad = ran.errors.find("b.png").expect("the bad file");
    let count = ran.errors.find("1 of 3 files failed").expect("the count");
    assert!(bad < count, "{ran:?}");
    assert!(ran.text.ends_with("2 files encoded\n"), "{ran:?}");
    // The lines of the others are there though the reader leaves.
    let line = "\"$0\" encode set --effort fast --force | head -c 1; test -f set/c.wtex";
    let status = std::process::Command::new("sh")
        .args(["-c", line])
        .arg(env!("CARGO_BIN_EXE_wavelet-tex"))
        .current_dir(&f.0)
        .status();
    assert!(status.expect("a shell").success());
}

#[test]
#[cfg(unix)]
fn a_folder_that_cannot_be_read_costs_no_other() {
    use std::os::unix::fs::PermissionsExt;
    let f = Folder::new("locked");
    fs::create_dir_all(f.0.join("set/locked")).expect("made");
    f.save("set/a.png", gray_image());
    let lock = |mode| {
        let path = f.0.join("set/locked");
        fs::set_permissions(path, fs::Permissions::from_mode(mode)).expect("set");
    };
    lock(0o000);
    if fs::read_dir(f.0.join("set/locked")).is_ok() {
        lock(0o755);
        return skipped("an unreadable folder: the user may read all folders");
    }
    let ran = f.run("encode set --effort fast");
    lock(0o755);
    assert_eq!(ran.code, Some(1));
    ran.says("locked: cannot be read");
    assert!(f.0.join("set/a.wtex").is_file());
}

#[test]
fn globs_take_brackets_by_name_and_keep_folders() {
    let f = Folder::new("brackets");
    for folder in ["tex[1]", "p/one", "p/two"] {
        f.save(&format!("{folder}/a.png"), gray_image());
    }
    f.ok("encode tex[1]/*.png --effort fast");
    assert!(f.0.join("tex[1]/a.wtex").is_file());
    f.ok("encode p/*/a.png --out out --effort fast");
    f.ok("encode p/t* --out folders --effort fast");
    for name in ["out/one/a.wtex", "out/two/a.wtex", "folders/two/a.wtex"] {
        assert!(f.0.join(name).is_file(), "{name}");
    }
}

#[test]
fn gltf_files_are_found_in_folders_and_share_their_images() {
    let f = Folder::new("gltfs");
    for (name, image) in [
        ("base", color_image()),
        ("bumps", normal_image()),
        ("alone", color_image()),
    ] {
        f.save(&format!("in/models/tex/{name}.png"), image);
    }
    let material = |base: usize| {
        json!([{
            "pbrMetallicRoughness": {"baseColorTexture": {"index": base}},
            "normalTexture": {"index": 1},
        }])
    };
    let uris = ["tex/base.png", "tex/bumps.png", "tex/gone.png"];
    f.write("in/models/a.gltf", &gltf(material(0), &uris));
    f.write("in/models/b.gltf", &gltf(material(2), &uris));
    let ran = f.run("encode in --out out --effort fast --json");
    // One image is missing, which costs no other.
    assert_eq!(ran.code, Some(1));
    ran.says("gone.png");
    let rows = ran.json();
    assert_eq!(rows.as_array().map(Vec::len), Some(3), "{rows}");
    for (name, content) in [("base", "color"), ("bumps", "normal"), ("alone", "color")] {
        let info = f.info(&format!("out/models/tex/{name}.wtex"));
        assert_eq!(info["content"], content, "{name}");
    }

    // Alone or with its folder, a model has the same textures.
    f.run("encode in/models/a.gltf --effort fast");
    let before = f.read("in/models/tex/bumps.wtex");
    let rows = f.run("encode in --effort fast --json").json();
    assert_eq!(f.read("in/models/tex/bumps.wtex"), before);
    let is_unchanged = |row: &&Value| row["unchanged"] == true;
    let unchanged = rows.as_array().expect("rows").iter().filter(is_unchanged);
    assert_eq!(unchanged.count(), 2, "{rows}");

    let outside = gltf(material(0), &["../tex/base.png", "../tex/bumps.png"]);
    f.write("in/models/sub/c.gltf", &outside);
    let ran = f.run("encode in/models/sub/c.gltf --out deep");
    ran.says("outside of the folder deep");
    assert!(!Path::new(&f.0.join("tex")).exists());
}

//! Tests of several files at once, of a required quality, and of the number of threads.

use std::{fs, process::Command};

use serde_json::Value;

use crate::support::{Folder, color_image, gray_image, stderr};

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
    assert_eq!(lines.lines().count(), 3, "{lines}");
    assert!(lines.ends_with("2 files encoded\n"), "{lines}");
    assert!(f.0.join("a2.wtex").is_file() && !f.0.join("b.wtex").exists());
    f.fails(1, &["encode", "c*.png"], &["c*.png", "no file fits"]);
    fs::create_dir(f.0.join("empty")).expect("made");
    f.fails(1, &["encode", "empty"], &["empty", "no .png or .jpg"]);
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
    for min_psnr in ["20", "37", "40"] {
        let rows = f.json(&["encode", "in.png", "--min-psnr", min_psnr, "--json"]);
        let (bpp, psnr) = (rows[0]["bpp"].as_f64(), rows[0]["psnr_db"].as_f64());
        assert!(psnr >= min_psnr.parse().ok(), "{min_psnr}: {rows}");
        assert!(bpp >= Some(last), "{min_psnr}: {rows}");
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
fn the_result_does_not_depend_on_the_number_of_threads() {
    let f = Folder::new("threads");
    f.save("in.png", color_image());
    f.ok(&["encode", "in.png", "--threads", "3"]);
    let mut results = vec![f.read("in.wtex")];
    for threads in ["1", "2", "5"] {
        let output = Command::new(env!("CARGO_BIN_EXE_wavelet-tex"))
            .current_dir(&f.0)
            .env("RAYON_NUM_THREADS", threads)
            .args(["encode", "in.png", "--force"])
            .output()
            .expect("the tool starts");
        assert!(output.status.success());
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
        let mut child = Command::new(env!("CARGO_BIN_EXE_wavelet-tex"))
            .current_dir(&f.0)
            .args([
                "encode",
                "in.png",
                "--force",
                "--threads",
                &threads.to_string(),
            ])
            .stdout(std::process::Stdio::null())
            .spawn()
            .expect("the tool starts");
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

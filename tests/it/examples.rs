//! The examples as a user starts them: each draws its committed picture.

use std::{env, fs, path::Path, process::Command};

use bevy_frugal_lab::metrics::flip::{DEFAULT_PIXELS_PER_DEGREE, flip_map};

use crate::support::{drawn, skipped};

/// Mean FLIP to the committed picture: what another adapter rounds differently is far below.
const MOST: f64 = 0.03;

#[test]
fn examples_draw_their_pictures() {
    let root = Path::new(bevy_frugal_lab::ROOT);
    let program = env::current_exe().expect("this test");
    let programs = program.ancestors().nth(2).expect("target").join("examples");
    let folder = root.join("target/examples");
    fs::create_dir_all(&folder).expect("a folder");
    let pictures = fs::read_dir(root.join("docs/images/examples")).expect("pictures");
    let mut pictures: Vec<_> = pictures
        .map(|picture| picture.expect("a picture").path())
        .collect();
    pictures.sort();
    assert!(pictures.len() >= 12, "{} pictures", pictures.len());
    for picture in drawn(1, pictures) {
        let name = picture
            .file_stem()
            .and_then(|name| name.to_str())
            .expect("a name");
        let example = programs.join(name);
        if !example.exists() {
            skipped(
                "the pictures of examples that are not built: `cargo build --release --workspace --examples`",
            );
            return;
        }
        let file = folder.join(format!("{name}.png"));
        let output = Command::new(&example).arg("--headless").arg(&file).output();
        let output = output.expect("it starts");
        let log = String::from_utf8_lossy(&output.stderr) + String::from_utf8_lossy(&output.stdout);
        assert!(output.status.success(), "{name}: {log}");
        assert!(!log.contains("ERROR"), "{name}: {log}");
        let [expected, actual] = [&picture, &file].map(|path| {
            let image =
                image::open(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
            image.into_rgb8()
        });
        let difference = flip_map(&expected, &actual, DEFAULT_PIXELS_PER_DEGREE)
            .expect("the same size")
            .mean();
        println!("{name}: {difference:.4}");
        assert!(
            difference < MOST,
            "{name}: mean FLIP {difference:.3}: {}",
            file.display()
        );
    }
}

//! The crate beside features of Bevy that bring the same native libraries: cargo refuses two crates that link one.

use std::{path::Path, process::Command};

use super::loading::Folder;
use crate::support::skipped;

/// What cargo says when it resolves a game with a feature of Bevy and the crate with these features.
fn resolve(feature: &str, features: &str) -> Result<(), String> {
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR"));
    let name = format!("resolve-{feature}-{features}");
    let folder = Folder::new(&name).with("lib.rs", b"");
    let manifest = format!(
        "[package]\n\
         name = 'probe'\n\
         edition = '2024'\n\
         [lib]\n\
         path = 'lib.rs'\n\
         [workspace]\n\
         [dependencies]\n\
         bevy = {{ version = '0.20.1', default-features = false, features = ['{feature}'] }}\n\
         bevy_wavelet_tex = {{ path = '{}', features = [{features}] }}\n",
        workspace.join("crates/bevy_wavelet_tex").display()
    );
    let lock = std::fs::read(workspace.join("Cargo.lock")).expect("a lock file");
    let folder = folder
        .with("Cargo.toml", manifest.as_bytes())
        .with("Cargo.lock", &lock);
    let cargo = std::env::var_os("CARGO").unwrap_or("cargo".into());
    let mut update = Command::new(cargo);
    // This downloads nothing but the registry's entries of what is new.
    update
        .args(["update", "--workspace"])
        .current_dir(&folder.0);
    let output = update.output().expect("cargo runs");
    if output.status.success() {
        return Ok(());
    }
    Err(String::from_utf8_lossy(&output.stderr).into_owned())
}

#[test]
fn a_game_can_have_bevys_compressed_image_saver() {
    match resolve("compressed_image_saver", "") {
        Ok(()) => {}
        Err(error) if error.contains("links to the native library") => panic!("{error}"),
        Err(error) => return skipped(&format!("bevy_wavelet_tex beside Bevy: {error}")),
    }
    // The test would see a conflict, which only the encoder has.
    let error = resolve("compressed_image_saver", "'encode'").expect_err("two BC7 encoders");
    assert!(error.contains("`bc7e`"), "{error}");
}

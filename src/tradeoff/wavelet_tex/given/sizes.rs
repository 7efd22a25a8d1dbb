//! The bytes of files on disk, and the time to read wavelet textures.

use std::{
    fmt::Write,
    path::{Path, PathBuf},
    time::Instant,
};

use bevy_wavelet_tex::file;

use super::super::inputs::files;
use crate::tradeoff::study::TradeoffError;

/// A row for each folder: its files, their mean bytes, and the time to read them where they are textures.
pub(super) fn table(folders: &[PathBuf]) -> Result<String, TradeoffError> {
    let mut text = String::from(
        "| folder | files | mean bytes | read, ms/Mpixel |\n| --- | --- | --- | --- |\n",
    );
    for folder in folders {
        text += &row(folder)?;
    }
    Ok(text)
}

fn row(folder: &Path) -> Result<String, TradeoffError> {
    let paths = files(folder, &["png", "jpg", "jpeg", file::EXTENSION])?;
    let (mut sum, mut read_ms, mut pixels) = (0, 0.0, 0.0);
    for path in &paths {
        let bytes = std::fs::read(path).map_err(TradeoffError::file(path))?;
        sum += bytes.len();
        if let Ok(texture) = file::read(&bytes) {
            read_ms += shortest_ms(|| file::read(&bytes));
            pixels += texture.size.map(f64::from).iter().product::<f64>();
        }
    }
    let mut text = format!(
        "| {} | {} | {:.0} |",
        folder.display(),
        paths.len(),
        sum as f64 / paths.len() as f64
    );
    if pixels > 0.0 {
        let _ = write!(text, " {:.2}", read_ms / (pixels / 1e6));
    }
    Ok(text + " |\n")
}

/// The shortest of five times, in milliseconds.
fn shortest_ms<T>(function: impl Fn() -> T) -> f64 {
    let times = (0..5).map(|_| {
        let start = Instant::now();
        std::hint::black_box(function());
        start.elapsed().as_secs_f64() * 1e3
    });
    times.fold(f64::INFINITY, f64::min)
}

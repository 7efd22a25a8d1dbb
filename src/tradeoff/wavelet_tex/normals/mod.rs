//! The angular error of normal maps as wavelet textures, in BC5 and in BC1: of a smooth and a rough
//! map that are generated, and of those that are given.

mod lighting;
mod map;

use std::path::Path;

use bevy_wavelet_tex::codec::{angle::Angles, encoder::EncodeError, settings::Method};
use image::RgbImage;
use indicatif::ProgressBar;

use self::map::{Format, NormalMap};
use super::inputs::files;
use crate::{
    record::Measurement,
    tradeoff::study::{TradeoffError, note},
};

pub(super) const EXACT: &str = "exact normals";

/// The rows of the generated maps, and of the maps in a folder.
pub(super) fn rows(
    folder: &Path,
    progress: &ProgressBar,
) -> Result<Vec<Measurement>, TradeoffError> {
    let mut rows = Vec::new();
    for (name, map) in [
        ("smooth", NormalMap::smooth()),
        ("rough", NormalMap::rough()),
    ] {
        rows.extend(of_map(name, &map)?);
    }
    if !folder.is_dir() {
        let text = format!("skipped: normal maps, not found in {}", folder.display());
        note(progress, &text);
        return Ok(rows);
    }
    for path in files(folder, &["png"])? {
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        if !name.ends_with("Normal") {
            continue;
        }
        let picture = image::open(&path).map_err(TradeoffError::file(&path))?;
        rows.extend(of_map(&name, &NormalMap::given(&picture.into_rgb32f()))?);
    }
    Ok(rows)
}

fn of_map(name: &str, map: &NormalMap) -> Result<Vec<Measurement>, EncodeError> {
    let row = |format: Format| {
        let (decoded, bytes) = map.through(format)?;
        let pairs = map.normals.iter().copied().zip(decoded.normals);
        let angles = Angles::between(pairs);
        Ok(Measurement {
            scene: name.into(),
            setting: format.name().into(),
            reference: EXACT.into(),
            bytes: Some(bytes as u64),
            angle_degrees: [
                ("mean".into(), angles.mean_angle_degrees),
                ("99 of 100".into(), angles.p99_angle_degrees),
                ("largest".into(), angles.max_angle_degrees),
            ]
            .into(),
            ..Measurement::default()
        })
    };
    Format::ALL.into_iter().map(row).collect()
}

/// A highlight on the smooth map, from left to right exact, in BC1, in BC5 and as a wavelet texture,
/// and below each the difference from exact, amplified ten times (thesis Fig. 3.24).
pub(super) fn highlight() -> Result<RgbImage, EncodeError> {
    let exact = NormalMap::smooth();
    let [bc1, bc5, wavelet] =
        [Format::Bc1, Format::Bc5, Format::Wavelet(Method::Best)].map(|f| exact.through(f));
    Ok(lighting::picture(&[&exact, &bc1?.0, &bc5?.0, &wavelet?.0]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_are_measured_beside_the_baselines() {
        let rows = rows(Path::new("no such folder"), &ProgressBar::hidden()).expect("rows");
        let mean = |scene: &str, format: &str| {
            let row = rows
                .iter()
                .find(|r| r.scene == scene && r.setting == format);
            let angles = &row
                .unwrap_or_else(|| panic!("no {scene} in {format}"))
                .angle_degrees;
            assert!(angles["mean"] <= angles["99 of 100"]);
            assert!(angles["99 of 100"] <= angles["largest"]);
            angles["mean"]
        };
        for map in ["smooth", "rough"] {
            // BC5 has twice the bits of `normal4`, BC1 as many.
            assert!(mean(map, "normal4") < mean(map, "BC1"), "{map}");
            assert!(mean(map, "BC5") < mean(map, "BC1"), "{map}");
        }
        assert!(mean("smooth", "normal4") < 0.2);
        assert!(mean("smooth", "BC5 of a lower resolution") < 5.0);
    }

    #[test]
    fn the_exact_map_has_no_error_and_that_of_bc1_is_visible() {
        let picture = highlight().expect("a map of a good size");
        assert_eq!(picture.dimensions(), (1280, 640));
        let largest_below = |panel: u32| {
            let shown =
                (320..640).flat_map(|y| (320 * panel..320 * (panel + 1)).map(move |x| (x, y)));
            shown
                .map(|(x, y)| picture.get_pixel(x, y)[0].abs_diff(128))
                .max()
        };
        assert_eq!(largest_below(0), Some(0));
        assert!(largest_below(1) > Some(100) && largest_below(3) < largest_below(1));
    }
}

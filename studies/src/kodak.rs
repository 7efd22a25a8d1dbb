//! The photographs of the Kodak set.

use image::RgbImage;
use indicatif::ProgressBar;

use super::{
    plan::Plan,
    study::{TradeoffError, note},
};

/// Names and pixels of the photographs with these numbers; none, with a note, where the folder is
/// missing.
pub(super) fn photographs(
    plan: &Plan,
    numbers: &[u32],
    progress: &ProgressBar,
) -> Result<Vec<(String, RgbImage)>, TradeoffError> {
    let folder = &plan.kodak_folder;
    if !folder.is_dir() {
        if !numbers.is_empty() {
            let text = format!(
                "skipped: the Kodak images, not found in {}",
                folder.display()
            );
            note(progress, &text);
        }
        return Ok(Vec::new());
    }
    let read = |number: &u32| {
        let name = format!("kodim{number:02}");
        let path = folder.join(&name).with_extension("png");
        let image = image::open(&path).map_err(TradeoffError::file(&path))?;
        Ok((name, image.into_rgb8()))
    };
    numbers.iter().map(read).collect()
}

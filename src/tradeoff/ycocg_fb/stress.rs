//! Frames beyond the scenes: other exposures, and photographs.

use bevy_ycocg_fb::reference::color::linear_from_srgb;
use indicatif::ProgressBar;

use super::{capture::hdr_frame, frame::Frame, scenes::SCENES};
use crate::tradeoff::{kodak, plan::Plan, study::TradeoffError};

/// Scenes and the factors that their exposure is multiplied by.
pub const EXPOSURES: [(&str, f32); 4] = [
    ("lit", 0.02),
    ("lit", 20.0),
    ("foliage", 0.02),
    ("foliage", 20.0),
];

/// The scenes at other exposures, with names such as `lit x20`.
pub fn exposures(size: [u32; 2]) -> Result<Vec<(String, Frame)>, TradeoffError> {
    let mut frames = Vec::new();
    for scene in &SCENES {
        let factors = EXPOSURES.iter().filter(|(name, _)| *name == scene.name);
        let factors: Vec<f32> = factors.map(|(_, factor)| *factor).collect();
        if factors.is_empty() {
            continue;
        }
        let frame = Frame::from(&hdr_frame(scene, size)?);
        let exposed = |factor: f32| (format!("{} x{factor}", scene.name), frame.scaled(factor));
        frames.extend(factors.into_iter().map(exposed));
    }
    Ok(frames)
}

/// The photographs of the Kodak set, taken as scene-linear frames, where they are.
pub fn photographs(
    plan: &Plan,
    progress: &ProgressBar,
) -> Result<Vec<(String, Frame)>, TradeoffError> {
    let photographs = kodak::photographs(plan, &plan.photographs, progress)?;
    let frame = |(name, image): (String, image::RgbImage)| {
        let (width, height) = image.dimensions();
        let frame = Frame::from_fn([width, height], |x, y| {
            let encoded = image.get_pixel(x, y).0;
            encoded.map(|byte| linear_from_srgb(f32::from(byte) / 255.0))
        });
        (name, frame)
    };
    Ok(photographs.into_iter().map(frame).collect())
}

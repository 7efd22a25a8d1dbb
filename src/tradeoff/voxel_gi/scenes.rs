//! The scenes with their truth.

use indicatif::ProgressBar;

use crate::{
    boxes::{BoxScene, TraceSettings, cornell_box, read_npy, trace},
    tradeoff::{TradeoffError, note, options::GiPlan},
};
use bevy::math::Vec3;

/// The scenes of the data.
pub const NAMES: [&str; 3] = ["cornell_point", "colonnade", "sunlit_room"];

/// Paths from each pixel where the truth is traced here.
const SAMPLES: u32 = 1024;

/// A scene and its path-traced indirect light.
pub struct TrueScene {
    /// Its numbers.
    pub scene: BoxScene,
    /// Radiance of its pixels.
    pub indirect: Vec<Vec3>,
    /// Who traced it.
    pub reference: &'static str,
}

/// The scenes in the folder of the plan, or the Cornell box traced here where there is none.
///
/// # Errors
/// [`TradeoffError::Truth`] for files that are not what they should be.
pub fn scenes(plan: &GiPlan, progress: &ProgressBar) -> Result<Vec<TrueScene>, TradeoffError> {
    let folder = &plan.folder;
    if !folder.exists() {
        let text = format!(
            "{} is not there: only the Cornell box is measured, against our own path tracer",
            folder.display()
        );
        note(progress, &text);
        let scene = cornell_box();
        let settings = TraceSettings {
            samples: SAMPLES,
            ..TraceSettings::default()
        };
        let indirect = trace(&scene, &settings).indirect;
        return Ok(vec![TrueScene {
            scene,
            indirect,
            reference: "path traced by the lab",
        }]);
    }
    let read = |name| {
        Ok(TrueScene {
            scene: BoxScene::read(folder, name)?,
            indirect: read_npy(&folder.join(format!("{name}.indirect.npy")))?,
            reference: "path traced",
        })
    };
    NAMES.into_iter().map(read).collect()
}

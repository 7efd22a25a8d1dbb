//! Frame times of settings that take turns: what slows the machine down for a while slows down all
//! of them.

use crate::{
    headless::{HeadlessApp, HeadlessError},
    record::Measurement,
};

/// A setting: its app and what is known of it so far.
pub struct Contestant {
    app: HeadlessApp,
    row: Measurement,
    gpu_ms: Vec<f64>,
    cpu_ms: Vec<f64>,
}

impl Contestant {
    /// An app that is ready to be measured, and its row without times.
    pub fn new(app: HeadlessApp, row: Measurement) -> Self {
        Self {
            app,
            row,
            gpu_ms: Vec::new(),
            cpu_ms: Vec::new(),
        }
    }

    /// The row with the medians of all rounds.
    fn finish(self) -> Measurement {
        Measurement {
            gpu_ms: median(self.gpu_ms),
            cpu_ms: median(self.cpu_ms),
            ..self.row
        }
    }
}

/// The rows of all contestants after `rounds` rounds of `frames` frames each.
///
/// # Errors
/// [`HeadlessError`] when a frame cannot be rendered.
pub fn contest(
    mut contestants: Vec<Contestant>,
    rounds: u32,
    frames: u32,
) -> Result<Vec<Measurement>, HeadlessError> {
    for _ in 0..rounds {
        for contestant in &mut contestants {
            let times = contestant.app.measure_frames(frames)?;
            contestant.gpu_ms.extend(times.gpu_ms);
            contestant.cpu_ms.extend(times.cpu_ms);
        }
    }
    Ok(contestants.into_iter().map(Contestant::finish).collect())
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

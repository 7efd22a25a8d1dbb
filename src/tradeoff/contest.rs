//! Frame times of settings that take turns: what slows the machine down for a while slows down all
//! of them.

use std::collections::BTreeMap;

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
    /// What the names of the spans begin with that the row is to have one by one.
    stages: Option<&'static str>,
    stage_ms: BTreeMap<String, Vec<f64>>,
}

impl Contestant {
    /// An app that is ready to be measured, and its row without times.
    pub fn new(app: HeadlessApp, row: Measurement) -> Self {
        Self {
            app,
            row,
            gpu_ms: Vec::new(),
            cpu_ms: Vec::new(),
            stages: None,
            stage_ms: BTreeMap::new(),
        }
    }

    /// The row is to have the times of the spans that begin with `prefix`, without it.
    pub fn with_stages(self, prefix: &'static str) -> Self {
        Self {
            stages: Some(prefix),
            ..self
        }
    }

    fn measure(&mut self, frames: u32) -> Result<(), HeadlessError> {
        let (times, spans) = self.app.measure_spans(frames)?;
        self.gpu_ms.extend(times.gpu_ms);
        self.cpu_ms.extend(times.cpu_ms);
        for (name, time) in spans {
            if let Some(stage) = self.stages.and_then(|prefix| name.strip_prefix(prefix)) {
                self.stage_ms.entry(stage.into()).or_default().push(time);
            }
        }
        Ok(())
    }

    /// The row with the medians of all rounds.
    fn finish(self) -> Measurement {
        Measurement {
            gpu_ms: median(self.gpu_ms),
            cpu_ms: median(self.cpu_ms),
            stage_ms: self
                .stage_ms
                .into_iter()
                .filter_map(|(name, times)| Some((name, median(times)?)))
                .collect(),
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
            contestant.measure(frames)?;
        }
    }
    Ok(contestants.into_iter().map(Contestant::finish).collect())
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

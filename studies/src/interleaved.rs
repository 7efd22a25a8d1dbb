//! An interleaved benchmark: each round has frames of every candidate, so that what slows the machine down
//! for a while slows down all of them.

use std::collections::BTreeMap;

use crate::record::Measurement;
use bevy_frugal_lab::headless::{FrameTimes, HeadlessApp, HeadlessError, median};

/// Something whose frames are measured, such as an app, and its row without times.
pub struct Candidate<T> {
    subject: T,
    row: Measurement,
    gpu_ms: Vec<f64>,
    cpu_ms: Vec<f64>,
    /// Prefix of the names of the spans that the row lists one by one.
    stages: Option<&'static str>,
    stage_ms: BTreeMap<String, Vec<f64>>,
}

impl<T> Candidate<T> {
    pub fn new(subject: T, row: Measurement) -> Self {
        Self {
            subject,
            row,
            gpu_ms: Vec::new(),
            cpu_ms: Vec::new(),
            stages: None,
            stage_ms: BTreeMap::new(),
        }
    }

    /// Adds the times of the spans whose names begin with `prefix` to the row, without the prefix.
    pub fn with_stages(self, prefix: &'static str) -> Self {
        Self {
            stages: Some(prefix),
            ..self
        }
    }

    fn record(&mut self, (times, spans): (FrameTimes, BTreeMap<String, f64>)) {
        self.gpu_ms.extend(times.gpu_ms);
        self.cpu_ms.extend(times.cpu_ms);
        for (name, time) in spans {
            if let Some(stage) = self.stages.and_then(|prefix| name.strip_prefix(prefix)) {
                self.stage_ms.entry(stage.into()).or_default().push(time);
            }
        }
    }

    fn finish(self) -> Measurement {
        let stages = self.stage_ms.into_iter();
        Measurement {
            gpu_ms: median(&self.gpu_ms),
            cpu_ms: median(&self.cpu_ms),
            stage_ms: stages
                .filter_map(|(name, times)| Some((name, median(&times)?)))
                .collect(),
            ..self.row
        }
    }
}

/// The rows of all candidates after `rounds` rounds, in each of which `measure` gives the times of
/// each candidate once.
pub fn benchmark<T>(
    mut candidates: Vec<Candidate<T>>,
    rounds: u32,
    mut measure: impl FnMut(&mut T) -> Result<(FrameTimes, BTreeMap<String, f64>), HeadlessError>,
) -> Result<Vec<Measurement>, HeadlessError> {
    for _ in 0..rounds {
        for candidate in &mut candidates {
            let times = measure(&mut candidate.subject)?;
            candidate.record(times);
        }
    }
    Ok(candidates.into_iter().map(Candidate::finish).collect())
}

/// The same of candidates that are an app each, with `frames` frames in a round.
pub fn benchmark_apps(
    candidates: Vec<Candidate<HeadlessApp>>,
    rounds: u32,
    frames: u32,
) -> Result<Vec<Measurement>, HeadlessError> {
    benchmark(candidates, rounds, |app| app.measure_spans(frames))
}

//! An interleaved benchmark: each round has frames of every candidate, so that what slows the machine down
//! for a while slows down all of them.

use std::collections::BTreeMap;

use bevy_frugal_lab::headless::{FrameTimes, HeadlessApp, HeadlessError, median};

use crate::record::{ReportAdapter, TimeRow, Times};

/// The times of something in all rounds.
#[derive(Default)]
struct Samples {
    gpu_ms: Vec<f64>,
    cpu_ms: Vec<f64>,
    stage_ms: BTreeMap<String, Vec<f64>>,
}

/// The median times of all candidates after `rounds` rounds, in each of which `measure` gives the times of each
/// candidate once, and those of its spans. Times have the spans whose names begin with `stages`, without that.
pub fn benchmark<T>(
    candidates: &mut [T],
    rounds: u32,
    stages: Option<&str>,
    mut measure: impl FnMut(&mut T) -> Result<(FrameTimes, BTreeMap<String, f64>), HeadlessError>,
) -> Result<Vec<Times>, HeadlessError> {
    let mut samples: Vec<_> = candidates.iter().map(|_| Samples::default()).collect();
    for _ in 0..rounds {
        for (candidate, samples) in candidates.iter_mut().zip(&mut samples) {
            let (times, spans) = measure(candidate)?;
            samples.gpu_ms.extend(times.gpu_ms);
            samples.cpu_ms.extend(times.cpu_ms);
            for (name, time) in spans {
                if let Some(stage) = stages.and_then(|prefix| name.strip_prefix(prefix)) {
                    samples.stage_ms.entry(stage.into()).or_default().push(time);
                }
            }
        }
    }
    let times = samples.into_iter().map(|samples| Times {
        gpu_ms: median(&samples.gpu_ms),
        cpu_ms: median(&samples.cpu_ms),
        stage_ms: { samples.stage_ms.into_iter() }
            .filter_map(|(name, times)| Some((name, median(&times)?)))
            .collect(),
    });
    Ok(times.collect())
}

/// The same of apps, with `frames` frames in a round; each row gets its times by `set`.
pub fn benchmark_apps<R>(
    candidates: Vec<(HeadlessApp, R)>,
    rounds: u32,
    frames: u32,
    stages: Option<&str>,
    set: impl Fn(R, Times) -> R,
) -> Result<Vec<R>, HeadlessError> {
    let (mut apps, rows): (Vec<_>, Vec<_>) = candidates.into_iter().unzip();
    let times = benchmark(&mut apps, rounds, stages, |app| app.measure_spans(frames))?;
    Ok(rows
        .into_iter()
        .zip(times)
        .map(|(row, times)| set(row, times))
        .collect())
}

/// The same of rows of times, and what rendered them.
pub fn time_rows(
    candidates: Vec<(HeadlessApp, TimeRow)>,
    rounds: u32,
    frames: u32,
    stages: Option<&str>,
) -> Result<(ReportAdapter, Vec<TimeRow>), HeadlessError> {
    let last = candidates.last();
    let adapter = last.map_or_else(ReportAdapter::default, |(app, _)| app.adapter().into());
    let rows = benchmark_apps(candidates, rounds, frames, stages, TimeRow::with_times)?;
    Ok((adapter, rows))
}

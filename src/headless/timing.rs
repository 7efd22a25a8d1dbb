//! Frame times.
//!
//! The CPU time is that of one update: scene systems, extraction and recording of the commands.
//! The GPU time is the sum of the top-level spans that Bevy's passes record; work outside a span
//! is not in it. Medians, as one hiccup of the system should not move the figure.

use std::{
    collections::{BTreeMap, HashMap},
    time::Duration,
};

use bevy::{diagnostic::DiagnosticsStore, ecs::world::World, platform::time::Instant};

/// Median times of a number of frames.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrameTimes {
    /// Time of the CPU in milliseconds; none when no frame was measured.
    pub cpu_ms: Option<f64>,
    /// Time of the GPU in milliseconds; none when the adapter has no timestamps or none of the
    /// frames has come back yet (they are a few frames late).
    pub gpu_ms: Option<f64>,
}

#[derive(Default)]
pub(crate) struct FrameClock {
    cpu_ms: Vec<f64>,
    gpu_ms: Vec<f64>,
    spans: BTreeMap<String, Vec<f64>>,
    seen: HashMap<String, Instant>,
}

impl FrameClock {
    /// A clock that does not count what was measured before.
    pub(crate) fn starting_now(world: &World) -> Self {
        let mut clock = Self::default();
        if let Some(store) = world.get_resource::<DiagnosticsStore>() {
            clock.new_spans(store);
        }
        clock
    }

    pub(crate) fn record(&mut self, cpu: Duration, world: &World) {
        self.cpu_ms.push(cpu.as_secs_f64() * 1e3);
        if let Some(store) = world.get_resource::<DiagnosticsStore>() {
            let spans = self.new_spans(store);
            if !spans.is_empty() {
                self.gpu_ms.push(spans.values().sum());
            }
            for (name, ms) in spans {
                self.spans.entry(name).or_default().push(ms);
            }
        }
    }

    /// Keeps only the last `count` frames, for a running median.
    pub(crate) fn keep_last(&mut self, count: usize) {
        let spans = self.spans.values_mut();
        for times in [&mut self.cpu_ms, &mut self.gpu_ms]
            .into_iter()
            .chain(spans)
        {
            times.drain(..times.len().saturating_sub(count));
        }
    }

    /// The medians so far.
    pub(crate) fn medians(&self) -> FrameTimes {
        FrameTimes {
            cpu_ms: median(&self.cpu_ms),
            gpu_ms: median(&self.gpu_ms),
        }
    }

    /// The median of each top-level span so far.
    pub(crate) fn span_medians(&self) -> BTreeMap<String, f64> {
        let spans = self.spans.iter();
        spans
            .filter_map(|(name, times)| Some((name.clone(), median(times)?)))
            .collect()
    }

    /// Times of the top-level spans that came in since the last call; of a span that came in
    /// several times, the sum.
    fn new_spans(&mut self, store: &DiagnosticsStore) -> BTreeMap<String, f64> {
        let mut spans = BTreeMap::new();
        for diagnostic in store.iter() {
            let path = diagnostic.path();
            let components: Vec<_> = path.components().collect();
            let ["render", name, "elapsed_gpu"] = components[..] else {
                continue;
            };
            for measurement in diagnostic.measurements() {
                let seen = self.seen.get(path.as_str());
                if seen.is_none_or(|seen| measurement.time > *seen) {
                    *spans.entry(name.to_string()).or_insert(0.0) += measurement.value;
                }
            }
            if let Some(last) = diagnostic.measurement() {
                self.seen.insert(path.as_str().into(), last.time);
            }
        }
        spans
    }
}

/// The median: the middle value, or the mean of the two middle ones.
pub fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let middle = sorted.len() / 2;
    match sorted.len() {
        0 => None,
        len if len % 2 == 1 => Some(sorted[middle]),
        _ => Some((sorted[middle - 1] + sorted[middle]) / 2.0),
    }
}

#[cfg(test)]
mod tests {
    use super::median;

    #[test]
    fn medians_of_few() {
        assert_eq!(median(&[]), None);
        assert_eq!(median(&[3.0]), Some(3.0));
        assert_eq!(median(&[4.0, 1.0]), Some(2.5));
        assert_eq!(median(&[9.0, 1.0, 2.0]), Some(2.0));
    }
}

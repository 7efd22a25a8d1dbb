//! What the threshold of the spatial method trades: fetches for accuracy.

use bevy_ewa::{EwaMethod, EwaProbes, EwaSettings};

use crate::record::Measurement;
use bevy_frugal_lab::lookups::{
    picture::{computed_picture, display},
    scenes::EwaScene,
};
use bevy_frugal_lab::metrics::{SizeMismatch, compare};

/// The thresholds, from nearly always to never.
const THRESHOLDS: [u16; 7] = [2, 4, 8, 12, 16, 24, 32];

/// The points of the curve, on samplers without anisotropy, whose probes are computed, and on those
/// with it, where a probe is one fetch. The error is against `ewa`; all of it is computed.
pub fn threshold_rows(scene: &EwaScene, size: u32) -> Result<Vec<Measurement>, SizeMismatch> {
    let texture = (scene.texture)();
    let coordinates = scene.coordinates(size);
    let picture = |settings: &EwaSettings| {
        let (pixels, fetches) = computed_picture(&texture, &coordinates, size, settings, 0);
        (display(&pixels, size), fetches)
    };
    let (reference, _) = picture(&EwaSettings::with_method(EwaMethod::Reference));
    let probes = EwaProbes::default();
    let mut rows = Vec::new();
    for (sampler_anisotropy, note) in [(1, ""), (16, ", 16x sampler")] {
        for threshold in THRESHOLDS {
            let (found, fetches) = picture(&EwaSettings {
                spatial_threshold: f32::from(threshold),
                sampler_anisotropy,
                ..EwaSettings::with_method(EwaMethod::Spatial { probes })
            });
            rows.push(Measurement {
                scene: scene.name.into(),
                setting: format!("spatial, threshold {threshold}{note}"),
                reference: "ewa".into(),
                fetches: Some(fetches),
                ..Measurement::from(&compare(&reference, &found)?)
            });
        }
    }
    Ok(rows)
}

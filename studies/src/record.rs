//! One record per measurement, in JSON.
//!
//! Every figure is optional, and absent in the file when it was not measured: no zero stands for
//! "unknown". An infinite PSNR (equal images) has no representation in JSON and is absent as well; `mse` is 0
//! then.

use std::{
    collections::BTreeMap,
    io,
    path::{Path, PathBuf},
    time::SystemTime,
};

use serde::{Deserialize, Serialize};
use thiserror::Error;

use bevy_frugal_lab::{headless::AdapterInfo, metrics::ImageError};

/// The figures of one plugin in one scene with one setting.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Measurement {
    pub plugin: String,
    pub scene: String,
    /// What was measured, e.g. `3 bits per pixel`.
    pub setting: String,
    /// What it was compared with, e.g. `uncompressed`.
    pub reference: String,
    /// Mean squared error in squared 8-bit units: 0 to 65025.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mse: Option<f64>,
    /// Peak signal-to-noise ratio in dB; absent when infinite.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub psnr_db: Option<f64>,
    /// Mean FLIP error: 0 (equal) to 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub flip: Option<f64>,
    /// Largest difference of a channel, in 8-bit units: 0 to 255.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_error: Option<f64>,
    /// Median time of the GPU in milliseconds a frame.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gpu_ms: Option<f64>,
    /// Median time of the CPU in milliseconds: of a frame, or of encoding or baking in rows without a
    /// frame.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cpu_ms: Option<f64>,
    /// Memory on the GPU in bytes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bytes: Option<u64>,
    /// Texture fetches a pixel.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fetches: Option<f64>,
    /// Bytes of textures that a pixel fetches; where it is an estimate, its study says how.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fetched_bytes: Option<f64>,
    /// Time over that of another setting, by the name of that.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub relative_time: BTreeMap<String, f64>,
    /// Mean absolute difference over mean reference, of radiance: 0 and above.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub relative_error: Option<f64>,
    /// Mean difference over mean reference, of radiance: above 0 where it is too bright.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bias: Option<f64>,
    /// Deviation of pixels on flat walls from their smooth neighbourhood over the mean, once all has settled.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise: Option<f64>,
    /// The same while a light moves at 1 m/s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise_in_motion: Option<f64>,
    /// Mean absolute difference of pixels between two successive frames of a still scene, over their mean.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub flicker: Option<f64>,
    /// Angles to the original normals in degrees, by name: mean, 99th percentile and largest.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub angle_degrees: BTreeMap<String, f64>,
    /// Median times of the plugin's own passes on the GPU in milliseconds a frame, by name.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub stage_ms: BTreeMap<String, f64>,
}

impl From<&ImageError> for Measurement {
    /// The four figures of the comparison; all else is empty.
    fn from(error: &ImageError) -> Self {
        Self {
            mse: Some(error.mse),
            psnr_db: error.psnr_db.is_finite().then_some(error.psnr_db),
            flip: Some(error.flip),
            max_error: Some(error.max_error.into()),
            ..Self::default()
        }
    }
}

/// Name and driver of the adapter that a report was made on.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ReportAdapter {
    pub name: String,
    pub driver: String,
}

impl From<&AdapterInfo> for ReportAdapter {
    fn from(info: &AdapterInfo) -> Self {
        Self {
            name: info.name.clone(),
            driver: info.driver.clone(),
        }
    }
}

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Report {
    pub adapter: ReportAdapter,
    /// The day it was made, as `YYYY-MM-DD`.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub date: String,
    /// The records, in the order of measuring.
    pub measurements: Vec<Measurement>,
}

/// A report could not be written.
#[derive(Debug, Error)]
#[error("cannot write the report `{}`: {source}", .path.display())]
pub struct WriteError {
    path: PathBuf,
    source: io::Error,
}

/// A report could not be read.
#[derive(Debug, Error)]
#[error("cannot read the report `{}`: {source}", .path.display())]
pub struct ReadError {
    path: PathBuf,
    source: io::Error,
}

impl Report {
    /// An empty report with the date of today.
    pub fn of_today() -> Self {
        let now = humantime::format_rfc3339_seconds(SystemTime::now()).to_string();
        Self {
            date: now.split('T').next().unwrap_or_default().into(),
            ..Self::default()
        }
    }

    /// Reads what [`write`](Self::write) wrote.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, ReadError> {
        let path = path.as_ref();
        std::fs::read(path)
            .and_then(|json| serde_json::from_slice(&json).map_err(io::Error::from))
            .map_err(|source| ReadError {
                path: path.into(),
                source,
            })
    }

    /// Writes the report as indented JSON, with a newline at its end.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), WriteError> {
        let path = path.as_ref();
        serde_json::to_vec_pretty(self)
            .map_err(io::Error::from)
            .and_then(|mut json| {
                json.push(b'\n');
                std::fs::write(path, json)
            })
            .map_err(|source| WriteError {
                path: path.into(),
                source,
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unmeasured_figures_and_infinities_are_absent() {
        let equal = ImageError {
            mse: 0.0,
            psnr_db: f64::INFINITY,
            max_error: 0,
            flip: 0.0,
        };
        let record = Measurement::from(&equal);
        let json = serde_json::to_value(&record).expect("serialises");
        assert_eq!(json["mse"], 0.0);
        assert!(json.get("psnr_db").is_none() && json.get("gpu_ms").is_none());
        let back: Measurement = serde_json::from_value(json).expect("deserialises");
        assert_eq!(back, record);
    }

    #[test]
    fn a_report_that_cannot_be_written_names_its_path() {
        let error = Report::default().write("/no/such/folder/report.json");
        let text = error.expect_err("no such folder").to_string();
        assert!(text.contains("/no/such/folder/report.json"), "{text}");
    }
}

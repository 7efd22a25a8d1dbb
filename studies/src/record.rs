//! What was measured, in JSON. A figure that was not measured is absent: no zero stands for "unknown".

use std::{
    collections::BTreeMap,
    error::Error,
    io,
    path::{Path, PathBuf},
    time::SystemTime,
};

use bevy_frugal_lab::{headless::AdapterInfo, metrics::ImageError};
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use thiserror::Error as ThisError;

/// How far a picture is from its reference.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PictureError {
    /// Mean squared error in squared 8-bit units: 0 to 65025.
    pub mse: f64,
    /// Peak signal-to-noise ratio in dB; absent when infinite, for equal pictures.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub psnr_db: Option<f64>,
    /// Mean FLIP error: 0 (equal) to 1.
    pub flip: f64,
    /// Largest difference of a channel, in 8-bit units: 0 to 255.
    pub max_error: f64,
}

impl From<ImageError> for PictureError {
    fn from(error: ImageError) -> Self {
        Self {
            mse: error.mse,
            psnr_db: error.psnr_db.is_finite().then_some(error.psnr_db),
            flip: error.flip,
            max_error: error.max_error.into(),
        }
    }
}

/// A picture with a setting, beside its reference.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PictureRow {
    pub scene: String,
    pub setting: String,
    /// What it was compared with.
    pub reference: String,
    #[serde(flatten)]
    pub error: PictureError,
    /// Median time of the CPU to make it, in milliseconds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cpu_ms: Option<f64>,
    /// Memory on the GPU in bytes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bytes: Option<u64>,
    /// Texture fetches a pixel.
    pub fetches: f64,
}

/// Median times in milliseconds a frame.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Times {
    /// Of the GPU.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gpu_ms: Option<f64>,
    /// Of the CPU.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cpu_ms: Option<f64>,
    /// Of the plugin's own passes on the GPU, by name.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub stage_ms: BTreeMap<String, f64>,
}

impl Times {
    /// That of the GPU where it has time stamps, otherwise that of the CPU.
    pub fn frame_ms(&self) -> Option<f64> {
        self.gpu_ms.or(self.cpu_ms)
    }
}

/// The times of a setting.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TimeRow {
    pub scene: String,
    pub setting: String,
    /// Memory on the GPU in bytes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bytes: Option<u64>,
    #[serde(flatten)]
    pub times: Times,
}

impl TimeRow {
    /// The row of a setting, without times.
    pub fn new(scene: impl Into<String>, setting: impl Into<String>) -> Self {
        Self {
            scene: scene.into(),
            setting: setting.into(),
            ..Self::default()
        }
    }

    pub fn with_times(self, times: Times) -> Self {
        Self { times, ..self }
    }
}

/// The times of plugins, in pictures of one size.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PluginTimes {
    /// Of the pictures.
    pub size: String,
    /// By name without `bevy_`.
    pub plugins: BTreeMap<String, Vec<TimeRow>>,
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

/// The rows of a study, with where and when they were measured.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Report<Rows> {
    pub adapter: ReportAdapter,
    /// The day it was made, as `YYYY-MM-DD`.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub date: String,
    #[serde(flatten)]
    pub rows: Rows,
}

/// A file could not be read or written.
#[derive(Debug, ThisError)]
#[error("`{}`: {source}", .path.display())]
pub struct FileError {
    path: PathBuf,
    source: io::Error,
}

impl FileError {
    pub fn new(path: &Path, source: impl Into<Box<dyn Error + Send + Sync>>) -> Self {
        Self {
            path: path.into(),
            source: io::Error::other(source),
        }
    }
}

/// Reads what [`write_json`] wrote.
pub fn read_json<T: DeserializeOwned>(path: &Path) -> Result<T, FileError> {
    let json = std::fs::read(path).and_then(|json| Ok(serde_json::from_slice(&json)?));
    json.map_err(|source| FileError::new(path, source))
}

/// Writes indented JSON, with a newline at its end, into a folder that is made where it is missing.
pub fn write_json<T: Serialize>(value: &T, path: &Path) -> Result<(), FileError> {
    let text = serde_json::to_string_pretty(value);
    write_text(
        &(text.map_err(|error| FileError::new(path, error))? + "\n"),
        path,
    )
}

/// The same of text.
pub fn write_text(text: &str, path: &Path) -> Result<(), FileError> {
    let made = path.parent().map_or(Ok(()), std::fs::create_dir_all);
    let written = made.and_then(|()| std::fs::write(path, text));
    written.map_err(|source| FileError::new(path, source))
}

impl<Rows: Serialize + DeserializeOwned> Report<Rows> {
    /// The same with the date of today.
    pub fn of_today(self) -> Self {
        let now = humantime::format_rfc3339_seconds(SystemTime::now()).to_string();
        Self {
            date: now.split('T').next().unwrap_or_default().into(),
            ..self
        }
    }

    /// Reads what [`write`](Self::write) wrote.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, FileError> {
        read_json(path.as_ref())
    }

    /// Writes the report as indented JSON.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), FileError> {
        write_json(self, path.as_ref())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reports_are_read_back() {
        #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
        struct Rows {
            pictures: Vec<PictureRow>,
            times: Vec<TimeRow>,
        }
        let report = Report {
            adapter: ReportAdapter {
                name: "llvmpipe".into(),
                driver: "Mesa 22".into(),
            },
            date: "2026-11-24".into(),
            rows: Rows {
                pictures: vec![PictureRow {
                    scene: "photo".into(),
                    error: PictureError {
                        mse: 0.25,
                        psnr_db: Some(54.0),
                        ..PictureError::default()
                    },
                    ..PictureRow::default()
                }],
                times: vec![TimeRow {
                    times: Times {
                        stage_ms: [("gather".into(), 1.0 / 3.0)].into(),
                        ..Times::default()
                    },
                    ..TimeRow::default()
                }],
            },
        };
        let path = std::env::temp_dir().join(format!("report-{}.json", std::process::id()));
        report.write(&path).expect("written");
        let text = std::fs::read_to_string(&path).expect("text");
        let read = Report::<Rows>::read(&path);
        std::fs::remove_file(&path).expect("removed");
        assert_eq!(read.expect("read"), report);
        assert!(text.ends_with("}\n") && !text.contains("gpu_ms"), "{text}");
    }

    #[test]
    fn equal_pictures_have_no_psnr() {
        let error = PictureError::from(ImageError {
            mse: 0.0,
            psnr_db: f64::INFINITY,
            max_error: 0,
            flip: 0.0,
        });
        assert_eq!((error.mse, error.psnr_db), (0.0, None));
    }

    #[test]
    fn a_file_that_cannot_be_read_or_written_is_named() {
        type AnyReport = Report<BTreeMap<String, f64>>;
        let read = AnyReport::read("no/such/report.json").expect_err("missing");
        let written = AnyReport::default().write("/dev/null/report.json");
        let written = written.expect_err("no folder").to_string();
        assert!(read.to_string().contains("no/such/report.json"), "{read}");
        assert!(written.contains("/dev/null/report.json"), "{written}");
    }
}

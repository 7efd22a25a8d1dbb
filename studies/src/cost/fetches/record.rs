//! The counts, in a file.

use bevy_frugal_lab::ROOT;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::cost::{error::CostError, record::read_json};

/// Where the committed figures are, relative to the repository.
pub const FOLDER: &str = "docs/measurements/llvmpipe";
/// Name of the file in its folder.
pub const FILE: &str = "fetches.json";

/// The mean number of fetches of a pixel.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FetchRow {
    /// Name of the plugin, or `bevy`.
    pub plugin: String,
    /// Name of the setting.
    pub setting: String,
    /// Name of the material.
    pub material: String,
    /// Name of the pass.
    pub pass: String,
    /// Fetches through a filter.
    pub samples: f64,
    /// Fetches of one texel.
    pub loads: f64,
    /// Fetches of one component of four texels.
    pub gathers: f64,
    /// Comparisons with the depth in a shadow map.
    pub comparisons: f64,
    /// Fetches of all kinds by Bevy alone, where it has the pass.
    pub baseline_fetches: Option<f64>,
}

impl FetchRow {
    /// Fetches of all kinds.
    pub fn fetches(&self) -> f64 {
        self.samples + self.loads + self.gathers + self.comparisons
    }
}

/// Reads the committed figures.
///
/// # Errors
/// [`CostError::File`].
pub fn read() -> Result<Vec<FetchRow>, CostError> {
    let root = Path::new(ROOT);
    read_json(&root.join(FOLDER).join(FILE))
}

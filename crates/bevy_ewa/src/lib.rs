//! Elliptical texture filtering.
pub mod reference;
pub mod settings;

pub use settings::{EwaKernel, EwaLevelOfDetail, EwaMethod, EwaProbes, EwaSettings};

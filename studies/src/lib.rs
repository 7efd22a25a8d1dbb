//! What each plugin costs and what it gains: accuracy, memory and time, as a
//! [`Report`](record::Report).
//!
//! A plugin's measurements are a [`Study`], one entry of [`STUDIES`].
//!
//! | module | contents |
//! | --- | --- |
//! | [`mod@record`] | measurements in JSON |
//! | [`mod@study`], [`studies`] | what a study is, and the list of all |
//! | [`plan`] | how much a study measures |
//! | [`options`], [`mod@run`] | the command line, and the reports that it asks for |
//! | [`interleaved`] | interleaved frame times of candidates |
//! | [`kodak`] | the photographs of the Kodak set |
//! | [`mod@wavelet_tex`], [`ycocg_fb`], [`ewa`], [`voxel_gi`] | the studies |
//! | [`mod@gpu`] | the times of all plugins on the GPU that is there |
//! | [`mod@cost`] | what the plugins' shaders cost, as a GPU's own compiler says |
//! | [`demo`] | the times of the demos' pictures |
//! | [`summary`] | what a user chooses between: each setting as one error and one cost |
//! | [`chart`] | a summary as a chart |
//! | [`markdown`] | summaries as a report, and as tables of advice |

pub mod chart;
pub mod cost;
pub mod demo;
pub mod ewa;
pub mod gpu;
pub mod interleaved;
pub mod kodak;
pub mod markdown;
pub mod options;
pub mod plan;
pub mod record;
pub mod run;
pub mod studies;
pub mod study;
pub mod subcommand;
pub mod summary;
pub mod voxel_gi;
pub mod wavelet_tex;
pub mod ycocg_fb;

pub use run::run;
pub use studies::STUDIES;
pub use study::{Study, TradeoffError};

#[cfg(test)]
mod tests;

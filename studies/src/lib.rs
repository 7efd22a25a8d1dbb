//! What each plugin costs and what it gains: accuracy, memory and time, as a
//! [`Report`](record::Report).
//!
//! | module | contents |
//! | --- | --- |
//! | [`mod@run`] | what a study is, the list of all, and the command line |
//! | [`plan`] | how much a study measures |
//! | [`mod@record`] | what was measured, in JSON |
//! | [`mod@benchmark`] | interleaved frame times of candidates |
//! | [`mod@wavelet_tex`], [`ycocg_fb`], [`ewa`], [`voxel_gi`] | the studies |
//! | [`mod@cost`] | what the plugins' shaders cost, as a GPU's own compiler says |
//! | [`mod@gpu`] | the times of all plugins on the GPU that is there |
//! | [`demo`] | the times of the demos' pictures |
//! | [`summary`] | what a user chooses between: each setting as one error and one cost, and its chart |
//! | [`page`] | summaries as a report, and tables in pages |

pub mod benchmark;
pub mod cost;
pub mod demo;
pub mod ewa;
pub mod gpu;
pub mod page;
pub mod plan;
pub mod record;
pub mod run;
pub mod summary;
pub mod voxel_gi;
pub mod wavelet_tex;
pub mod ycocg_fb;

pub use run::run;

/// Frames before which every asset must have been loaded and every pipeline compiled.
const MAX_FRAMES: u32 = 200;

#[cfg(test)]
mod tests;

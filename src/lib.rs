//! The lab: what the examples, tests and benches of the plugins share.
//!
//! | module | gives |
//! | --- | --- |
//! | [`boxes`] | scenes in plain numbers, and their path-traced light |
//! | [`mod@compose`] | shaders as Bevy composes them, in plain WGSL |
//! | [`content`] | procedural textures and photographs |
//! | [`mod@cost`] | what the plugins' shaders cost, as a GPU's own compiler says |
//! | [`headless`] | Bevy without a window, the same frames on every run |
//! | [`meshes`] | scenes of meshes with textures, and their path-traced light |
//! | [`metrics`] | how far a picture is from its reference |
//! | [`path_tracer`] | path tracing on the CPU |
//! | [`mod@record`] | measurements in JSON |
//! | [`runner`] | one runner for all examples: window, headless, settings |
//! | [`scenes`] | the example scenes |
//! | [`gallery`] | all scenes in one window or on one page |
//! | [`mod@subcommand`] | the `main` of a word on the command line |
//! | [`stage`] | lights, sky and camera of a scene |
//! | [`mod@tradeoff`] | accuracy, memory and time of each plugin, as a report |

pub mod boxes;
pub mod compose;
pub mod content;
pub mod cost;
pub mod gallery;
pub mod headless;
pub mod meshes;
pub mod metrics;
pub mod path_tracer;
pub mod record;
pub mod runner;
pub mod scenes;
pub mod stage;
pub mod subcommand;
pub mod tradeoff;

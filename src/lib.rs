//! The lab: what the examples, tests, benches and studies of the plugins share.
//!
//! | module | gives |
//! | --- | --- |
//! | [`boxes`] | scenes in plain numbers, and their path-traced light |
//! | [`mod@compose`] | shaders as Bevy composes them, in plain WGSL |
//! | [`content`] | procedural textures and photographs; pictures as wavelet textures |
//! | [`headless`] | Bevy without a window, the same frames on every run |
//! | [`lookups`] | texture lookups by the shaders of `bevy_ewa`, one a pixel |
//! | [`meshes`] | scenes of meshes with textures, and their path-traced light |
//! | [`metrics`] | how far a picture is from its reference |
//! | [`path_tracer`] | path tracing on the CPU |
//! | [`runner`] | one runner for all examples: window, headless, settings |
//! | [`scenes`] | the example scenes |
//! | [`gallery`] | all scenes in one window or on one page |
//! | [`stage`] | lights, sky and camera of a scene |
//! | [`testing`] | what tests of pictures share: the right to run apps, and their log |

pub mod boxes;
pub mod compose;
pub mod content;
pub mod gallery;
pub mod headless;
pub mod lookups;
pub mod meshes;
pub mod metrics;
pub mod path_tracer;
pub mod runner;
pub mod scenes;
pub mod stage;
pub mod testing;

/// The root of the repository.
pub const ROOT: &str = env!("CARGO_MANIFEST_DIR");

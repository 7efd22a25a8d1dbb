//! The example scenes. A new one is a module and a line in [`ALL`].

pub mod deferred_accumulation;
pub mod wavelet_tex;

use crate::runner::Scene;

/// Every scene, in the order of the gallery; the first is the one that opens by default.
pub static ALL: &[&dyn Scene] = &[
    &wavelet_tex::WaveletTex,
    &deferred_accumulation::DeferredAccumulation,
];

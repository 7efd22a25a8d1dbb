//! The example scenes. A new one is a module and a line in [`ALL`].

use crate::runner::Scene;

pub mod all_together;
pub mod deferred_accumulation;
mod error_view;
pub mod ewa;
pub mod tone;
pub mod voxel_gi;
pub mod wavelet_tex;
pub mod ycocg_fb;

/// Every scene, in the order of the gallery; the first is the one that opens by default.
pub static ALL: &[&dyn Scene] = &[
    &wavelet_tex::WaveletTex,
    &ycocg_fb::YCoCgFb,
    &ewa::Ewa,
    &voxel_gi::VoxelGi,
    &all_together::AllTogether,
    &deferred_accumulation::DeferredAccumulation,
];

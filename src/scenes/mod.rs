//! The example scenes. A new one is a module and a line in [`ALL`].

use bevy::color::LinearRgba;
use bevy_voxel_gi::Sky;

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

/// Light from outside: a clear sky, and sunlit ground below it.
fn clear_sky() -> Sky {
    Sky {
        zenith: LinearRgba::rgb(2200.0, 3200.0, 5000.0),
        horizon: LinearRgba::rgb(4200.0, 4700.0, 5200.0),
        ground: LinearRgba::rgb(6500.0, 6000.0, 5000.0),
    }
}

//! The studies, one a plugin.

use super::{ewa, study::Study, voxel_gi, wavelet_tex, ycocg_fb};

/// All studies, in the order in which they are measured.
pub const STUDIES: &[Study] = &[
    wavelet_tex::STUDY,
    ycocg_fb::STUDY,
    ewa::STUDY,
    voxel_gi::STUDY,
];

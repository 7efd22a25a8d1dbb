//! The voxel GI in pictures.

mod reference;
mod support;
mod truth;

//! The voxel GI in pictures.

mod support;
mod truth;

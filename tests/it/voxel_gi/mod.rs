//! The voxel GI in pictures.

mod basics;
mod extremes;
mod reference;
mod scene;
mod support;
mod truth;

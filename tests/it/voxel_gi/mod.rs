//! The voxel GI in pictures.

mod basics;
mod budget;
mod extremes;
mod materials;
mod memory;
mod rays;
mod receiver;
mod reference;
mod scene;
mod support;
mod surfaces;
mod truth;
mod turns;
mod volumes;

//! The compute passes of a frame, in this order:
//!
//! | pass | what it does |
//! | --- | --- |
//! | [`scroll`] | moves stored light along with a volume that moves |
//! | [`voxelize`] | meshes to voxels |
//! | [`compact`] | lists the surfaces and the empty voxels |
//! | [`mod@solve`] | direct light ([`inject`]), then ray tracing ([`gather`]) or propagation ([`propagate`]) |
//! | [`share`] | smooths traced light between neighbouring surfaces of one plane |
//! | [`reproject`] | albedo from cameras' G-buffers to voxels |
//!
//! Each has its shader beside it. [`bindings`] has the resources that they share, [`kernel`] makes their
//! pipelines, and `shaders/` is the shader library.

pub(crate) mod bindings;
mod compact;
mod gather;
mod inject;
mod kernel;
mod plugin;
mod propagate;
mod reproject;
mod scroll;
mod share;
mod solve;
mod voxelize;

pub(crate) use plugin::PassesPlugin;

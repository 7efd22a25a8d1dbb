//! The compute passes of a frame, in this order:
//!
//! | pass | what it does |
//! | --- | --- |
//! | [`mod@draw_sky`] | the game's sky to a small map that rays see |
//! | [`draw_tiles`] | textures of materials and lights to the tiles that `tiles.wesl` samples |
//! | [`voxelize`] | meshes to voxels, where something has changed: occupancy, then surfaces |
//! | [`allocate`] | slots for the faces that have a surface, between the two; their light moves along |
//! | [`compact`] | lists the surfaces and the empty voxels; writes what divides new voxels |
//! | [`mod@solve`] | direct light ([`inject`], with textures by `projection.wesl`), then ray tracing and sharing ([`gather`]) or propagation ([`propagate`]) |
//! | [`mod@read_back`] | counts for later frames |
//! | [`reproject`] | albedo from cameras' G-buffers to voxels |
//! | [`mod@mark_visible`] | what cameras see to voxels, for the next frame |
//!
//! Each has its shader beside it. [`bindings`] has the resources that they share, [`mod@g_buffer`] those of a
//! camera, [`kernel`] makes their pipelines, and `shaders/` is the shader library.

mod allocate;
pub(crate) mod bindings;
mod compact;
pub(crate) mod draw_sky;
mod draw_tiles;
mod g_buffer;
mod gather;
mod inject;
mod kernel;
mod mark_visible;
mod plugin;
mod propagate;
mod read_back;
mod reproject;
mod solve;
mod voxelize;

pub(crate) use plugin::PassesPlugin;

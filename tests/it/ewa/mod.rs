//! Elliptical filtering on the GPU.

mod exact;
mod materials;
mod mips;
mod scene;
mod shaders;
mod textures;

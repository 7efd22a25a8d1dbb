//! Elliptical filtering on the GPU.

mod anisotropic;
mod exact;
mod games;
mod materials;
mod mips;
mod pipelines;
mod scene;
mod shaders;
mod shared;
mod textures;

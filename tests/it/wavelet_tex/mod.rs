//! What the GPU makes of wavelet textures, against the reference decoder.

mod decode;
mod driver;
mod exact;
mod exchange;
mod filters;
mod gltf;
mod loading;
mod materials;
mod modes;
mod neighbours;
mod parity;
mod plain;
mod processing;
mod reference;
mod resolution;
mod scene;
mod shaders;
mod stochastic;
mod swapping;
mod twin;
mod viewer;

pub use scene::gpu_with_all_planes;

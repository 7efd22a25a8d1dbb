//! What the GPU makes of wavelet textures, against the reference decoder.

mod blocks;
mod decode;
mod filters;
mod gltf;
mod loading;
mod parity;
mod processing;
mod reference;
mod scene;
mod shaders;
mod stochastic;
mod twin;

pub use scene::gpu_with_all_planes;

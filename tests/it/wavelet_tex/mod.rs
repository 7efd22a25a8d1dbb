//! What the GPU makes of wavelet textures, against the reference decoder.

mod decode;
mod filters;
mod gltf;
mod loading;
mod parity;
mod processing;
mod scene;
mod twin;

pub use scene::gpu_with_all_planes;

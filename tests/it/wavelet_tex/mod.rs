//! What the GPU makes of wavelet textures, against the reference decoder.

mod decode;
mod loading;
mod materials;
mod scene;
mod shaders;

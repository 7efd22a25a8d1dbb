//! What the GPU makes of wavelet textures, against the reference decoder.

mod decode;
mod driver;
mod exact;
mod loading;
mod materials;
mod scene;
mod shaders;

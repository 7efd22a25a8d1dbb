//! The codec in plain Rust, without Bevy: the reference that the shader is tested against.
//!
//! An image becomes planes (luma and two chromas, or gray, or the X and Y of a normal), each plane
//! one level of the Haar transform, and the four coefficients of every 2 x 2 pixels one RGBA texel
//! of a BC3 texture: the mean in alpha, which BC3 stores with 4 bits a texel, the three details in
//! RGB, which share 4 bits a texel (thesis section 3.5). 8 bits for 4 pixels are 2 bits per pixel.
//!
//! | file | stage | thesis |
//! | --- | --- | --- |
//! | [`color`] | RGB and luma / chroma | 3.3.1 |
//! | [`plane`] | planes, mips, chroma subsampling | 3.5.5 |
//! | [`haar`] | Haar and partially inverted Haar | 3.5.1 |
//! | [`quantizer`] | range and power curve of the details | 3.5.2 |
//! | [`blocks`] | BC3 blocks | 3.4.2 |
//! | [`layout`] | sizes of planes, coefficient textures and mip chains | |
//! | [`encoder`], [`search`] | all of it forwards, and the choice of the parameters | 3.5.2 |
//! | [`decoder`] | all of it backwards | 3.5.3 |

pub mod blocks;
pub mod color;
pub mod decoder;
#[cfg(feature = "encode")]
pub mod encoder;
pub mod haar;
pub mod image;
pub mod layout;
pub mod plane;
pub mod quantizer;
#[cfg(feature = "encode")]
pub mod search;

//! The codec in plain Rust, without Bevy: the reference that the shader is tested against.
//!
//! An image becomes planes (luma and two chromas, or gray, or the X and Y of a normal). Luma takes
//! one level of the Haar transform, and the four coefficients of every 2 x 2 pixels become one RGBA
//! texel of a BC3 texture: the mean in alpha, which BC3 stores with 4 bits a texel, the three
//! details in RGB, which share 4 bits a texel (thesis section 3.5). 8 bits for 4 pixels are 2 bits
//! per pixel. Only what the neighbouring means do not foretell of the details is stored. Chroma is
//! made small and left to the texture unit to interpolate.
//!
//! | file | stage | thesis |
//! | --- | --- | --- |
//! | [`rate`], [`mod@image`] | what there is to choose, and what comes out | 3.5.5 |
//! | [`source`], [`reduce`] | pixels as they come, their mips, smaller ones | |
//! | [`color`] | RGB and luma / chroma | 3.3.1 |
//! | [`plane`], [`chroma`] | planes, and how they are made smaller | 3.5.5 |
//! | [`haar`] | Haar and partially inverted Haar | 3.5.1 |
//! | [`predict`] | the details that the means foretell | |
//! | [`quantizer`] | range and power curve of the details | 3.5.2 |
//! | [`blocks`] | BC blocks | 3.4.2 |
//! | [`wavelet`] | one plane into blocks and back | 3.5.3 |
//! | [`layout`] | sizes of planes, their textures and mip chains | |
//! | [`encoder`], [`search`] | all of it forwards, and the choice of the parameters | 3.5.2 |
//! | [`decoder`] | all of it backwards | 3.5.3 |
//! | [`quality`] | the error of both | 3.6.1 |

pub mod blocks;
pub mod chroma;
pub mod color;
pub mod decoder;
#[cfg(feature = "encode")]
pub mod encoder;
pub mod haar;
pub mod image;
pub mod layout;
pub mod plane;
#[cfg(feature = "encode")]
mod planes;
pub mod predict;
#[cfg(feature = "encode")]
pub mod quality;
pub mod quantizer;
pub mod rate;
#[cfg(feature = "encode")]
pub mod reduce;
#[cfg(feature = "encode")]
pub mod search;
#[cfg(feature = "encode")]
pub mod source;
pub mod wavelet;

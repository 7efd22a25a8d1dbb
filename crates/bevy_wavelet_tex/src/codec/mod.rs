//! The codec in plain Rust, without Bevy. Its decoder is the reference that the shader is tested
//! against.
//!
//! The encoder splits an image into planes: luma and two chromas, gray alone, or the X and Y of a
//! normal. It applies one level of the Haar transform to luma, and the four coefficients of every 2
//! x 2 pixels become one RGBA texel of a BC3 texture. The low band (LL / 2, the mean of the four
//! pixels) is stored in alpha, to which BC3 gives 4 bits a texel; the three detail bands (HL, LH,
//! HH) are stored in RGB, which share 4 bits a texel (thesis section 3.5). 8 bits for 4 pixels are
//! 2 bits per pixel. Both sides predict the details from the neighbouring values of the low band,
//! so only the residual is stored. Chroma is downsampled, and the texture unit interpolates it.
//!
//! In the code, `low` is a value of the low band and `details` are the coefficients of the detail
//! bands.
//!
//! | module | stage | thesis |
//! | --- | --- | --- |
//! | [`rate`], [`mod@image`] | the rates to choose from, the kind of data, and the encoded image | 3.5.5 |
//! | [`packing`] | how planes are packed into textures | 3.5.3 |
//! | [`source`], `prepare`, [`reduce`] | input pixels, their mips, colour of clear pixels, what masks cover, and downsampling to a size limit | |
//! | [`color`], [`axes`] | conversion between RGB and luma / chroma, of YCoCg or fitted | 3.3.1 |
//! | [`plane`], [`chroma`], [`interpolation`] | planes and their downsampling | 3.5.5 |
//! | [`plain`] | textures without a wavelet, at full size or smaller | |
//! | [`haar`] | the Haar and the partially inverted Haar transform | 3.5.1 |
//! | [`predict`] | prediction of the detail bands from the low band | |
//! | [`quantizer`] | range and power curve of the detail coefficients | 3.5.2 |
//! | [`blocks`] | BC blocks | 3.4.2 |
//! | [`wavelet`], `pack` | conversion of one plane to coefficients, to blocks and back | 3.5.3 |
//! | [`layout`] | sizes of planes, their textures and mip chains | |
//! | [`encoder`], `job` | the whole encoder: of an image, which kind of texture it becomes, and of its levels | 3.5.2 |
//! | [`settings`], `search` | its settings, and the search for its parameters | 3.5.2 |
//! | [`decoder`] | the whole decoder | 3.5.3 |
//! | [`quality`], [`angle`] | the error of an encoded image, and of normals | 3.6.1 |

pub mod axes;
pub mod blocks;
pub mod color;
pub mod decoder;
#[cfg(feature = "encode")]
pub mod encoder;
pub mod haar;
pub mod image;
pub mod interpolation;
#[cfg(feature = "encode")]
mod job;
pub mod layout;
#[cfg(feature = "encode")]
mod pack;
pub mod plain;
pub mod plane;
pub mod predict;
#[cfg(feature = "encode")]
mod prepare;
#[cfg(feature = "encode")]
pub mod quality;
pub mod quantizer;
pub mod rate;
#[cfg(feature = "encode")]
mod search;
#[cfg(feature = "encode")]
pub mod settings;
#[cfg(feature = "encode")]
pub mod source;
pub mod wavelet;

pub use interpolation::chroma;
pub use layout::packing;
#[cfg(feature = "encode")]
pub use quality::angle;
#[cfg(feature = "encode")]
pub use source::reduce;

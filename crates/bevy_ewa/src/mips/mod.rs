//! Mip levels of textures that lack them.
//!
//! Bevy generates no mip levels for PNG and JPEG files, and without them distant surfaces cannot be filtered. The
//! levels of this module are computed in linear light, count every texel of odd sizes once, renormalize normals, weight
//! colours by their alpha and keep the coverage of alpha masks. [`chain`] computes them on the CPU and is the reference
//! for the passes that do so on the GPU, from what is there: the images of the app stay as they are.
//!
//! Bevy's own `MipGenerationJobs` are no help for this: they need storage textures, which sRGB formats cannot be, and
//! levels that the app has allocated; they average 2 x 2 texels for any size and any content.
//!
//! | module | contents |
//! | --- | --- |
//! | [`chain`] | the mip levels of a texture on the CPU, with the coverage of alpha masks |
//! | [`texel`] | conversion of texel formats to linear light and back |
//! | `generator` | which images get mip levels, and the passes that generate them and keep the coverage of alpha masks |

pub mod chain;
#[cfg(feature = "bevy")]
pub(crate) mod generator;
pub mod texel;

pub use chain::{MipChain, MipContent, generate_mip_chain};
#[cfg(feature = "bevy")]
pub use generator::NoMips;
pub use texel::TexelFormat;

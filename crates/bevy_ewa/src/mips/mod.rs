//! Mip chains for textures that lack them.
//!
//! Bevy generates no mip levels for PNG and JPEG files, and without them distant surfaces cannot be
//! filtered. Its `MipGenerationJobs` are meant for textures that shaders write: they do not support
//! sRGB formats, which every base colour has, need storage textures, average 2 x 2 texels for any
//! size, and leave normals shorter. The chains of this module are computed in linear light, count every
//! texel of odd sizes once, and renormalize normals.
//!
//! | module | contents |
//! | --- | --- |
//! | [`chain`] | generation of mip levels in linear light |
//! | [`texel`] | conversion of texel formats to linear light and back |
//! | `lacking` | images without mip levels that can have them |
//! | `load` | mip chains for the textures of materials as they are loaded |

pub mod chain;
#[cfg(feature = "bevy")]
pub(crate) mod lacking;
#[cfg(feature = "bevy")]
pub(crate) mod load;
pub mod texel;

pub use chain::{MipChain, generate_mip_chain};
pub use texel::TexelFormat;

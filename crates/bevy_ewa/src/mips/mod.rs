//! Mip chains for textures that lack them.
//!
//! Bevy makes none for PNG and JPEG files, and without them nothing that is far away can be
//! filtered. Its `MipGenerationJobs` are for textures that shaders write: they take no sRGB format,
//! which every base colour has, need textures that shaders may store to, average 2 x 2 texels
//! whatever the size, and leave normals shorter. These chains are in linear light, count every texel
//! of odd sizes once, and renormalise.
//!
//! | module | gives |
//! | --- | --- |
//! | [`mod@chain`] | the levels of a texture, in linear light |
//! | [`texel`] | formats, as numbers in linear light and back |
//! | `load` | chains for the textures of materials, as they are loaded |

pub mod chain;
#[cfg(feature = "bevy")]
pub(crate) mod load;
pub mod texel;

pub use chain::{Chain, chain};
pub use texel::TexelFormat;

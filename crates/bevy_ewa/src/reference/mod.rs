//! The filters in plain Rust and 64-bit floats: what the shaders are tested against.
//!
//! | module | gives |
//! | --- | --- |
//! | [`texture`] | a texture with its mip chain, and what a texture unit does with it |
//! | [`footprint`] | the ellipse of a pixel, its mip level, its budget |
//! | [`kernel`] | the weight of a texel |
//! | [`exact`] | the weighted average of the texels of an ellipse |
//! | [`probes`] | a few anisotropic fetches in its place |
//! | [`mod@sample`] | a lookup by any method |
//! | [`scenes`] | pictures to filter, as functions of a point on the screen |
//! | [`truth`] | what those pictures should look like |

pub mod exact;
pub mod footprint;
pub mod kernel;
pub mod probes;
pub mod sample;
pub mod scenes;
pub mod texture;
pub mod truth;

pub use footprint::{Derivatives, Footprint};
pub use sample::{Sampled, sample};
pub use texture::{AddressMode, Level, Texture};

#[cfg(test)]
mod tests;

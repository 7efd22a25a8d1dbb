//! The filters in plain Rust and 64-bit floats, as the reference for the shaders' tests.
//!
//! | module | contents |
//! | --- | --- |
//! | [`texture`] | a texture with its mip chain, and a texture unit's lookups |
//! | [`footprint`] | the ellipse of a pixel, its mip level and its fetch budget |
//! | [`exact`] | the weighted average of the texels in an ellipse, and the kernels |
//! | [`probes`] | the approximation of an ellipse by a few anisotropic fetches |
//! | [`mod@stochastic`] | one fetch at a random point of the ellipse |
//! | [`mod@sample`] | a lookup by any method |
//! | [`scenes`] | test scenes as functions of a point on the screen, and their ground truth |

pub mod exact;
pub mod footprint;
pub mod probes;
pub mod sample;
pub mod scenes;
pub mod stochastic;
pub mod texture;

pub use footprint::{Derivatives, Footprint};
pub use sample::{Sampled, sample};
pub use texture::{AddressMode, Level, Texture};

#[cfg(test)]
pub(crate) mod tests;

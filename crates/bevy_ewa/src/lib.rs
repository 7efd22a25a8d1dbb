//! Elliptical texture filtering.
//!
//! The filter of a pixel is round; its image in a texture is an ellipse. The Elliptical Weighted
//! Average is the mean of the texels in that ellipse, and this crate has it from reference quality
//! to nearly the speed of the texture unit (P. Mavridis, *Efficient Texture Representation and
//! Sampling Algorithms for Real-time Rendering*, 2013, chapter 5).
//!
//! | room | what is in it |
//! | --- | --- |
//! | [`settings`] | what a user chooses |
//! | [`budget`] | settings by what they may cost |
//! | [`mips`] | mip chains for textures that lack them |
//! | [`mod@reference`] | all of it in plain Rust, with scenes and their truth |
//! | `shaders` | all of it in WESL, importable |
//! | `material` | how Bevy's materials come to use it |
//! | `plugin` | what an app adds |
//!
//! Without the feature `bevy` only the first four are compiled, [`mips`] without its systems.
#![cfg_attr(feature = "bevy", doc = "\n---\n")]
#![cfg_attr(feature = "bevy", doc = include_str!("../README.md"))]

pub mod budget;
#[cfg(feature = "bevy")]
pub mod material;
pub mod mips;
#[cfg(feature = "bevy")]
pub mod plugin;
pub mod reference;
pub mod settings;

pub use budget::EwaBudget;
#[cfg(feature = "bevy")]
pub use material::{AllMaterials, EwaExtension, EwaStandardMaterial, EwaUniform};
#[cfg(feature = "bevy")]
pub use plugin::EwaPlugin;
pub use settings::{EwaKernel, EwaLevelOfDetail, EwaMethod, EwaProbes, EwaSettings};

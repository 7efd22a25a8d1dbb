//! Elliptical texture filtering.
//!
//! The reconstruction filter of a pixel is a disc on the screen, which projects to an ellipse in a
//! texture. The Elliptical Weighted Average (EWA) is the weighted mean of the texels in that ellipse.
//! This crate implements it with methods from reference quality to nearly the speed of the texture unit
//! (P. Mavridis, *Efficient Texture Representation and Sampling Algorithms for Real-time Rendering*,
//! 2013, chapter 5).
//!
//! | module | contents |
//! | --- | --- |
//! | [`settings`] | the settings of the filter |
//! | [`budget`] | settings by their cost in texture fetches |
//! | [`mips`] | mip levels for textures that lack them |
//! | [`mod@reference`] | the filters in plain Rust, with test scenes and their ground truth |
//! | `shaders` | the filters as WESL modules, and the settings as their uniform buffer |
//! | `material` | the integration into Bevy's materials |
//! | `plugin` | the plugin that an app adds |
//! | `report` | what each texture got |
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
#[cfg(feature = "bevy")]
pub mod report;
pub mod settings;
#[cfg(feature = "bevy")]
pub mod shaders;

pub use budget::{EwaBudget, EwaErrorBound};
#[cfg(feature = "bevy")]
pub use material::{
    AllMaterials, EwaExtension, EwaImage, EwaMaterialPlugin, EwaMipSystems, EwaOverrides,
    EwaStandardMaterial,
};
#[cfg(feature = "bevy")]
pub use plugin::EwaPlugin;
#[cfg(feature = "bevy")]
pub use report::{EwaReport, MipReport, TextureReport};
pub use settings::{EwaKernel, EwaLevelOfDetail, EwaMaps, EwaMethod, EwaProbes, EwaSettings};
#[cfg(feature = "bevy")]
pub use shaders::EwaUniform;

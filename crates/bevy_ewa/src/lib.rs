//! Mip levels, anisotropy and elliptical texture filtering.
//!
//! Without the feature `bevy` only [`settings`], [`budget`], [`mod@reference`] and [`mips`], without its systems, are
//! compiled.
#![cfg_attr(feature = "bevy", doc = "\n---\n")]
// The first definition of a link counts: on docs.rs the README's lead to the repository.
#![cfg_attr(feature = "bevy", doc = concat!("[figures]: ", env!("CARGO_PKG_REPOSITORY"), "/blob/main/docs/ewa.md"))]
#![cfg_attr(feature = "bevy", doc = concat!("[migration]: ", env!("CARGO_PKG_REPOSITORY"), "/blob/main/docs/migration.md"))]
#![cfg_attr(feature = "bevy", doc = concat!("[picture]: ", env!("CARGO_PKG_REPOSITORY"), "/raw/main/docs/images/ewa.jpg"))]
#![cfg_attr(feature = "bevy", doc = concat!("[shaders]: ", env!("CARGO_PKG_REPOSITORY"), "/blob/main/docs/custom-shaders.md"))]
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

/// What most apps use: `use bevy_ewa::prelude::*`.
#[cfg(feature = "bevy")]
pub mod prelude {
    pub use crate::{
        AllMaterials, EwaExtension, EwaImage, EwaMaterialPlugin, EwaMethod, EwaOverrides,
        EwaPlugin, EwaReport, EwaSettings, EwaStandardMaterial,
    };
}

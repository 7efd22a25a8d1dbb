//! The maps of a material that are filtered.

#[cfg(feature = "bevy")]
use bevy::prelude::*;

/// The maps of Bevy's materials that the filter applies to.
///
/// Maps of the same size and UV set share the ellipse and the weights of their texels, so that another one costs its
/// fetches and little more.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "bevy",
    derive(Reflect),
    reflect(Default, Debug, Clone, PartialEq, Hash)
)]
pub struct EwaMaps {
    /// The base colour with its alpha, which also cuts the holes of alpha masks. Default: true.
    pub base_color: bool,
    /// The emitted light. Default: true.
    pub emissive: bool,
    /// The normals, also those of the clearcoat. Default: true.
    pub normals: bool,
    /// All other maps: metallic and roughness, occlusion, specular, clearcoat, transmission, anisotropy. Default:
    /// false.
    pub others: bool,
}

impl Default for EwaMaps {
    fn default() -> Self {
        Self {
            base_color: true,
            emissive: true,
            normals: true,
            others: false,
        }
    }
}

impl EwaMaps {
    /// All maps.
    pub const ALL: Self = Self {
        base_color: true,
        emissive: true,
        normals: true,
        others: true,
    };
    /// No map.
    pub const NONE: Self = Self {
        base_color: false,
        emissive: false,
        normals: false,
        others: false,
    };

    /// Returns true if a map of a `StandardMaterial` is one of them, by its name in the fields `*_texture`.
    pub fn contains(self, map: &str) -> bool {
        match map {
            "base_color" => self.base_color,
            "emissive" => self.emissive,
            "normal_map" | "clearcoat_normal" => self.normals,
            _ => self.others,
        }
    }
}

//! The settings of all materials, of single ones, and what the app decides for single images.

use std::collections::{HashMap, HashSet};

use bevy::{
    asset::UntypedAssetId,
    pbr::{ExtendedMaterial, MaterialExtension, StandardMaterial},
    prelude::*,
    render::render_resource::AsBindGroup,
};

use crate::settings::{EwaMethod, EwaSettings};

/// Settings of the filter for all `StandardMaterial`s of the app, and for the materials of an
/// [`EwaMaterialPlugin`](crate::EwaMaterialPlugin); `None` leaves them to Bevy.
///
/// A change takes effect in the next frame and builds new pipelines; the assets stay unchanged.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Resource, Default, Debug, Clone, PartialEq)]
pub struct AllMaterials(pub Option<EwaSettings>);

impl Default for AllMaterials {
    fn default() -> Self {
        Self(Some(EwaSettings::with_method(EwaMethod::Anisotropic)))
    }
}

/// A `StandardMaterial` whose maps are filtered by the settings of its extension.
pub type EwaStandardMaterial = ExtendedMaterial<StandardMaterial, EwaExtension>;

/// The extension that holds the settings for one material's maps.
#[derive(Asset, AsBindGroup, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Default, Debug, Clone, PartialEq)]
pub struct EwaExtension {
    /// Settings of the filter. Changing them builds a new pipeline.
    pub settings: EwaSettings,
}

impl From<EwaSettings> for EwaExtension {
    fn from(settings: EwaSettings) -> Self {
        Self { settings }
    }
}

impl MaterialExtension for EwaExtension {}

/// Decisions for single images and materials, which go before the settings of all materials.
///
/// An override stays until it is cleared, also when its asset is removed and loaded again.
#[derive(Resource, Clone, Debug, Default, Reflect)]
#[reflect(Resource, Default, Debug, Clone)]
pub struct EwaOverrides {
    images: HashMap<AssetId<Image>, EwaImage>,
    #[reflect(ignore)]
    materials: HashMap<UntypedAssetId, Option<EwaSettings>>,
    /// What has changed since the plugin looked last.
    #[reflect(ignore)]
    pub(super) changed_images: HashSet<AssetId<Image>>,
    #[reflect(ignore)]
    pub(super) changed_materials: HashSet<UntypedAssetId>,
}

impl EwaOverrides {
    /// Decides what the plugin does with an image, in all materials that show it.
    pub fn set_image(&mut self, id: impl Into<AssetId<Image>>, image: EwaImage) {
        let id = id.into();
        self.images.insert(id, image);
        self.changed_images.insert(id);
    }

    /// Leaves an image to the plugin's defaults again.
    pub fn clear_image(&mut self, id: impl Into<AssetId<Image>>) {
        let id = id.into();
        self.images.remove(&id);
        self.changed_images.insert(id);
    }

    /// Returns what the plugin does with an image.
    pub fn image(&self, id: impl Into<AssetId<Image>>) -> EwaImage {
        self.images.get(&id.into()).copied().unwrap_or_default()
    }

    /// Filters one material, of any type whose plugin is added, by these settings in place of
    /// [`AllMaterials`]; `None` leaves it to Bevy.
    pub fn set_material(&mut self, id: impl Into<UntypedAssetId>, settings: Option<EwaSettings>) {
        let id = id.into();
        self.materials.insert(id, settings);
        self.changed_materials.insert(id);
    }

    /// Filters one material as all others again.
    pub fn clear_material(&mut self, id: impl Into<UntypedAssetId>) {
        let id = id.into();
        self.materials.remove(&id);
        self.changed_materials.insert(id);
    }

    /// Returns the override of a material, if there is one.
    pub fn material(&self, id: impl Into<UntypedAssetId>) -> Option<Option<EwaSettings>> {
        self.materials.get(&id.into()).copied()
    }
}

/// What the plugin does with an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Reflect)]
#[reflect(Debug, Default, Clone, PartialEq)]
pub struct EwaImage {
    /// Whether the image is left as it is: no mip levels, no anisotropy, no ellipses. Default: false.
    pub is_excluded: bool,
    /// Upper limit of the number of mip levels, the finest included. It limits generated levels only. Default: no
    /// limit. See [`EwaImage::atlas`].
    pub max_levels: u32,
    /// Whether the image is filtered although its sampler chooses the nearest texel when magnified or minified. Such
    /// images are left alone otherwise, since pixel art is meant to look so. Default: false.
    pub use_nearest: bool,
    /// Whether an image to which cameras draw or shaders write gets mip levels: after each camera that draws to it,
    /// and in [`EwaMipSystems`](crate::EwaMipSystems) before all cameras for images that shaders write. The levels are
    /// a second texture, which materials show. Default: false, without levels.
    pub after_draws: bool,
}

impl Default for EwaImage {
    fn default() -> Self {
        Self {
            is_excluded: false,
            max_levels: u32::MAX,
            use_nearest: false,
            after_draws: false,
        }
    }
}

impl EwaImage {
    /// An image that is left as it is.
    pub const EXCLUDED: Self = Self {
        is_excluded: true,
        max_levels: u32::MAX,
        use_nearest: false,
        after_draws: false,
    };

    /// An atlas of cells of this size in texels, as many of which begin at multiples of it. It has those levels in
    /// which no texel belongs to two cells: 5 for cells of 16 x 16, 1 for cells of odd size.
    ///
    /// Bilinear filtering and anisotropy still read half a texel and more beyond the border of a cell, which atlases
    /// are padded for.
    pub fn atlas(cell: UVec2) -> Self {
        Self {
            max_levels: cell.x.trailing_zeros().min(cell.y.trailing_zeros()) + 1,
            ..default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_of_an_atlas_do_not_mix_cells() {
        let levels = |x, y| EwaImage::atlas(UVec2::new(x, y)).max_levels;
        assert_eq!(levels(16, 16), 5);
        assert_eq!(levels(32, 24), 4);
        assert_eq!(levels(17, 16), 1);
    }
}

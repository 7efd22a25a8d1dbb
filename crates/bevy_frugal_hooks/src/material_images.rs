//! Images of materials whose maps are other kinds of textures, for plugins that read maps outside of the materials' own
//! shaders.

use bevy::{
    asset::{AssetId, UntypedAssetId},
    ecs::resource::Resource,
    image::Image,
    mesh::UvChannel,
    platform::collections::HashMap,
};

/// A small image that looks as a map does from afar.
#[derive(Clone, Debug, PartialEq)]
pub struct MapImage {
    /// The image, whose coordinates repeat.
    pub image: AssetId<Image>,
    /// The texture coordinates of the map.
    pub channel: UvChannel,
}

/// The images of a material's maps. `None` where it has no such map, or has it as an image of its own.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MapImages {
    /// Multiplied with the base colour.
    pub base_color: Option<MapImage>,
    /// Multiplied with the emissive colour.
    pub emissive: Option<MapImage>,
    /// Its blue channel is multiplied with the metallic value.
    pub metallic_roughness: Option<MapImage>,
}

/// The images of materials by their assets.
///
/// Plugins that read them insert this resource when they are built. Plugins with such materials fill it where it is, after
/// `AssetEventSystems` in `PostUpdate`, so that nothing is made that nobody reads.
#[derive(Resource, Clone, Debug, Default)]
pub struct MaterialImages(pub HashMap<UntypedAssetId, MapImages>);

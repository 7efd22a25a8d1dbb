//! The tiles of the textures of lights. The texture that holds them exists only while a light has one.

use bevy::{
    ecs::name::NameOrEntity,
    platform::collections::HashSet,
    prelude::*,
    render::{Extract, render_asset::RenderAssets, renderer::RenderDevice, texture::GpuImage},
};

use super::{
    asset_notes::AssetNotes,
    tiles::{
        ADDRESS_BORDER, ADDRESS_CLAMP, ADDRESS_REPEAT, NoTile, TileContent, Tiles, address_code,
    },
};
use crate::extract::{
    light_textures::{LightTexture, TextureCoverage},
    lights::ExtractedLights,
};

/// The tiles of the textures of lights.
#[derive(Resource, Default)]
pub(crate) struct LightTiles {
    pub tiles: Tiles,
    /// Lights whose texture has no tile, and why: to warn of.
    without: Vec<(Entity, NoTile)>,
    /// The images that have been warned of.
    known: HashSet<AssetId<Image>>,
}

impl LightTiles {
    fn note(&mut self, texture: &LightTexture, reason: NoTile) {
        if reason != NoTile::NotLoaded && self.known.insert(texture.image) {
            self.without.push((texture.light, reason));
        }
    }
}

/// Asks for the tiles of the textures of lights. Lights without one shine as without a texture, as in Bevy.
pub(crate) fn prepare_light_tiles(
    mut light_tiles: ResMut<LightTiles>,
    mut lights: ResMut<ExtractedLights>,
    (images, notes): (Res<RenderAssets<GpuImage>>, Res<AssetNotes>),
    device: Res<RenderDevice>,
) {
    let lights = &mut *lights;
    if lights.textures.is_empty() && light_tiles.tiles.view().is_none() {
        return;
    }
    let light_tiles = &mut *light_tiles;
    light_tiles.tiles.begin();
    for (index, texture) in &lights.textures {
        let content = match texture.coverage {
            TextureCoverage::Cube(cells) => TileContent::LightCube(cells),
            _ => TileContent::Light,
        };
        let [u, v] = match texture.coverage {
            TextureCoverage::Cone => notes.address(texture.image).map(address_code),
            TextureCoverage::Tiled => [ADDRESS_REPEAT; 2],
            TextureCoverage::Single => [ADDRESS_BORDER; 2],
            TextureCoverage::Cube(_) => [ADDRESS_CLAMP; 2],
        };
        let key = (texture.image, content);
        match light_tiles.tiles.of(key, (&images, &notes, &device)) {
            Ok((place, _)) => {
                let light = &mut lights.lights[*index];
                light.tile_first = place.first;
                light.tile_size = place.size.x | place.size.y << 16;
                light.tile_address = u | v << 2;
            }
            Err(reason) => light_tiles.note(texture, reason),
        }
    }
    light_tiles.tiles.end();
}

/// Warns of lights whose texture has no tile, by their names, which only the main world has.
pub(crate) fn warn_of_missing_tiles(
    mut light_tiles: ResMut<LightTiles>,
    names: Extract<Query<NameOrEntity>>,
) {
    if light_tiles.without.is_empty() {
        return;
    }
    for (light, reason) in light_tiles.without.drain(..) {
        let Ok(light) = names.get(light) else {
            continue;
        };
        match reason {
            NoTile::NotLoaded => (),
            NoTile::Unreadable(format, dimension) => warn!(
                "voxel GI: the texture of the light {light} has the format {format:?} and dimension {dimension:?}, which \
                 cannot be read, so volumes have its light as without a texture. Use a two-dimensional colour image"
            ),
            NoTile::NoRoom(bytes) => warn!(
                "voxel GI: the textures of lights take more than the {} MiB that this device has for them, so volumes \
                 have the light {light} as without a texture. Use fewer textures",
                bytes >> 20
            ),
        }
    }
}

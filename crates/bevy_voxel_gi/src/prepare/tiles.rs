//! Small copies of textures, which compute shaders sample: any format that the GPU samples becomes one, and one texture
//! holds all. Each has a chain of mip levels, and up to 2,048 texels in the first.

use bevy::{
    ecs::name::NameOrEntity,
    image::ImageAddressMode,
    platform::collections::{HashMap, HashSet},
    prelude::*,
    render::{
        Extract,
        render_asset::RenderAssets,
        render_resource::{
            ShaderType, Texture, TextureDimension, TextureFormat, TextureSampleType, TextureUsages,
            TextureView, TextureViewDescriptor, TextureViewDimension, TextureViewId,
        },
        renderer::RenderDevice,
        texture::GpuImage,
    },
};

use super::{asset_notes::AssetNotes, buffers::texture};
use crate::extract::lights::{CubeCells, ExtractedLights, LightTexture, TextureCoverage};

/// The part of a texture that a tile holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum TileContent {
    /// The colour, whatever its alpha.
    Color,
    /// Alpha, and the colour weighted by it.
    Covered,
    /// The fraction of texels whose alpha is at least this, in 255ths; and the colour of these.
    Masked(u16),
    /// The colour, of any brightness.
    Emission,
    /// The red channel, of any brightness.
    Light,
    /// The same of the six faces of a cube, squares one below the other.
    LightCube(CubeCells),
}

impl TileContent {
    /// Keep in sync with `draw_tiles.wesl`.
    fn code(self) -> (u32, f32) {
        match self {
            Self::Color => (0, 0.0),
            Self::Covered => (1, 0.0),
            // Halfway to the value below: texels of 8 bits are exact.
            Self::Masked(cutoff) => (2, (f32::from(cutoff) - 0.5) / 255.0),
            Self::Emission => (3, 0.0),
            Self::Light | Self::LightCube(_) => (4, 0.0),
        }
    }

    /// Where the faces of a cube are in the texture; any other texture is a single face.
    fn cells(self) -> CubeCells {
        match self {
            Self::LightCube(cells) => cells,
            _ => CubeCells::ONE,
        }
    }

    /// Size of the first level of the tile of a texture of this size.
    fn tile_size(self, size: UVec2) -> UVec2 {
        match self {
            Self::LightCube(cells) => cube_tile_size(size / cells.grid),
            _ => tile_size(size),
        }
    }

    /// The level of the texture to draw from into a tile of this size.
    fn source_level(self, source: UVec2, levels: u32, tile: UVec2) -> u32 {
        let CubeCells { grid, faces, .. } = self.cells();
        source_level(source, levels, grid * tile / UVec2::new(1, faces))
    }
}

// How coordinates outside of 0 to 1 are brought into a texture; keep in sync with `tiles.wesl`.
const ADDRESS_CLAMP: u32 = 0;
const ADDRESS_REPEAT: u32 = 1;
const ADDRESS_MIRROR: u32 = 2;
/// There is nothing outside; only for lights.
const ADDRESS_BORDER: u32 = 3;

pub(super) fn address_code(mode: ImageAddressMode) -> u32 {
    match mode {
        ImageAddressMode::ClampToEdge | ImageAddressMode::ClampToBorder => ADDRESS_CLAMP,
        ImageAddressMode::Repeat => ADDRESS_REPEAT,
        ImageAddressMode::MirrorRepeat => ADDRESS_MIRROR,
    }
}

type TileKey = (AssetId<Image>, TileContent);

/// The place of a tile in the texture of all tiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct TilePlace {
    /// Index of its first texel.
    pub first: u32,
    pub size: UVec2,
}

struct Tile {
    place: TilePlace,
    /// Texels of all its levels.
    texels: u32,
    /// The view of the texture that is drawn into it.
    view: TextureViewId,
    is_drawn: bool,
    /// Level of the texture that is drawn.
    level: u32,
    /// Cameras may render to its texture.
    is_target: bool,
    is_used: bool,
}

/// The uniform of the shader that draws a tile.
#[derive(ShaderType, Clone, Copy, Debug)]
pub(crate) struct TileJob {
    pub size: UVec2,
    pub first: u32,
    pub level: u32,
    pub content: u32,
    pub cutoff: f32,
    pub grid: UVec2,
    pub columns: u32,
    pub rows: u32,
    pub faces: u32,
}

/// Why a texture has no tile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NoTile {
    /// It is not on the GPU yet.
    NotLoaded,
    /// Compute shaders cannot read it.
    Unreadable(TextureFormat, TextureDimension),
    /// All tiles take as many bytes as the device has for them.
    NoRoom(u64),
}

/// All tiles of materials whose meshes reach into a level, or in [`LightTiles`] of lights.
#[derive(Resource, Default)]
pub(crate) struct Tiles {
    tiles: HashMap<TileKey, Tile>,
    texture: Option<(Texture, TextureView)>,
    /// First texels and lengths of what is free, in order.
    free: Vec<(u32, u32)>,
    /// Increases when a tile has another content.
    pub(super) version: u64,
    /// Whether a tile is to be drawn anew, as its image was not on the GPU when it was asked for.
    pub(super) is_waiting: bool,
}

/// Texels in a row of the texture; `TILE_ROW` in `tiles.wesl`.
const ROW: u32 = 1024;
/// Most texels of a tile's first level: with the others it has at most 11 KiB.
const MOST_TEXELS: u32 = 2048;
/// Most texels of the source that one texel of a tile is the mean of, along an axis.
const MOST_SOURCE: u32 = 8;

/// Size of the first level of a texture of this size that has few enough texels.
fn tile_size(size: UVec2) -> UVec2 {
    let mut tile = size.max(UVec2::ONE);
    while u64::from(tile.x) * u64::from(tile.y) > u64::from(MOST_TEXELS) {
        // Squares stay squares: the voxelisers choose a level for both axes.
        let larger = tile.max_element();
        tile = UVec2::select(tile.cmpeq(UVec2::splat(larger)), tile / 2, tile);
    }
    tile
}

/// Size of the first level of a cube whose faces have this size. Its edge is a power of two, so that no texel of a
/// smaller level has parts of two faces.
fn cube_tile_size(face: UVec2) -> UVec2 {
    let most = (MOST_TEXELS / 6).isqrt();
    let edge = 1 << face.min_element().clamp(1, most).ilog2();
    UVec2::new(edge, 6 * edge)
}

/// Number of texels of all levels.
fn texels_of(mut size: UVec2) -> u32 {
    let mut texels = size.x * size.y;
    while size != UVec2::ONE {
        size = (size / 2).max(UVec2::ONE);
        texels += size.x * size.y;
    }
    texels
}

/// The level of a texture in which a texel of the tile covers few texels.
fn source_level(size: UVec2, levels: u32, tile: UVec2) -> u32 {
    let level = |level: u32| (size >> level).max(UVec2::ONE);
    (0..levels.saturating_sub(1))
        .take_while(|&l| (level(l) / tile).max_element() > MOST_SOURCE)
        .count() as u32
}

/// Whether compute shaders can read a texture.
fn is_readable(image: &GpuImage, device: &RenderDevice) -> bool {
    let descriptor = &image.texture_descriptor;
    let view = image.texture_view_descriptor.as_ref();
    let dimension = view.and_then(|view| view.dimension);
    let format = view
        .and_then(|view| view.format)
        .unwrap_or(descriptor.format);
    let is_flat = match dimension {
        Some(dimension) => dimension == TextureViewDimension::D2,
        None => descriptor.size.depth_or_array_layers == 1,
    };
    let sample_type = format.sample_type(None, Some(device.features()));
    is_flat
        && descriptor.dimension == TextureDimension::D2
        && descriptor.sample_count == 1
        && descriptor.usage.contains(TextureUsages::TEXTURE_BINDING)
        && matches!(sample_type, Some(TextureSampleType::Float { .. }))
}

impl Tiles {
    /// Begins to ask for all tiles in use.
    pub(super) fn begin(&mut self) {
        self.is_waiting = false;
        for tile in self.tiles.values_mut() {
            tile.is_used = false;
        }
    }

    /// The tile of a texture, and whether it has another content than when tiles were drawn last.
    pub(super) fn of(
        &mut self,
        key: TileKey,
        (images, notes, device): (&RenderAssets<GpuImage>, &AssetNotes, &RenderDevice),
    ) -> Result<(TilePlace, bool), NoTile> {
        let Some(image) = images.get(key.0) else {
            self.is_waiting = true;
            return Err(NoTile::NotLoaded);
        };
        let descriptor = &image.texture_descriptor;
        if !is_readable(image, device) {
            return Err(NoTile::Unreadable(descriptor.format, descriptor.dimension));
        }
        let source = UVec2::new(descriptor.size.width, descriptor.size.height);
        let size = key.1.tile_size(source);
        let level = (key.1).source_level(source, descriptor.mip_level_count, size);
        let view = image.texture_view.id();
        if let Some(tile) = self.tiles.get_mut(&key)
            && tile.place.size == size
        {
            tile.is_used = true;
            if tile.view != view || notes.uploaded.contains(&key.0) {
                (tile.view, tile.level, tile.is_drawn) = (view, level, false);
                self.version += 1;
            }
            return Ok((tile.place, !tile.is_drawn));
        }
        if let Some(other) = self.tiles.remove(&key) {
            self.release(other.place.first, other.texels);
        }
        let texels = texels_of(size);
        let first = self.allocate(texels, device)?;
        let place = TilePlace { first, size };
        let is_target = descriptor.usage.contains(TextureUsages::RENDER_ATTACHMENT);
        self.tiles.insert(
            key,
            Tile {
                place,
                texels,
                view,
                is_drawn: false,
                level,
                is_target,
                is_used: true,
            },
        );
        self.version += 1;
        Ok((place, true))
    }

    /// Releases the tiles that were not asked for since [`begin`](Self::begin).
    pub(super) fn end(&mut self) {
        let unused: Vec<_> = self
            .tiles
            .iter()
            .filter(|(_, tile)| !tile.is_used)
            .map(|(key, tile)| (*key, tile.place.first, tile.texels))
            .collect();
        for (key, first, texels) in unused {
            self.tiles.remove(&key);
            self.release(first, texels);
        }
        if self.tiles.is_empty() {
            self.texture = None;
            self.free.clear();
        }
    }

    /// A place for so many texels; a larger texture takes the place of one that has none.
    fn allocate(&mut self, texels: u32, device: &RenderDevice) -> Result<u32, NoTile> {
        if let Some(range) = self.free.iter().position(|(_, length)| *length >= texels) {
            let (first, length) = self.free[range];
            if length == texels {
                self.free.remove(range);
            } else {
                self.free[range] = (first + texels, length - texels);
            }
            return Ok(first);
        }
        let rows = self.rows();
        // Half as many again, so that it grows seldom.
        let more = texels.div_ceil(ROW).max(rows / 2);
        let most = device.limits().max_texture_dimension_2d;
        if rows + more > most || device.limits().max_texture_dimension_2d < ROW {
            return Err(NoTile::NoRoom(4 * u64::from(ROW) * u64::from(most)));
        }
        let usage = TextureUsages::TEXTURE_BINDING
            | TextureUsages::STORAGE_BINDING
            | TextureUsages::COPY_SRC
            | TextureUsages::COPY_DST;
        let size = [ROW, rows + more, 1];
        let texture = texture(
            device,
            "voxel_gi_tiles",
            size,
            TextureFormat::R32Uint,
            usage,
        );
        let view = texture.create_view(&TextureViewDescriptor::default());
        for tile in self.tiles.values_mut() {
            tile.is_drawn = false;
        }
        self.texture = Some((texture, view));
        self.release(rows * ROW, more * ROW);
        self.allocate(texels, device)
    }

    fn release(&mut self, first: u32, length: u32) {
        let place = self.free.partition_point(|(start, _)| *start < first);
        self.free.insert(place, (first, length));
        // Neighbours become one.
        self.free.dedup_by(|next, range| {
            let adjoins = range.0 + range.1 == next.0;
            if adjoins {
                range.1 += next.1;
            }
            adjoins
        });
    }

    fn rows(&self) -> u32 {
        self.texture
            .as_ref()
            .map_or(0, |(texture, _)| texture.height())
    }

    /// What is to be drawn before the scene is voxelised: what is new, and what cameras may have rendered to.
    pub(crate) fn take_jobs(
        &mut self,
        images: &RenderAssets<GpuImage>,
    ) -> Vec<(TextureView, TileJob)> {
        let tiles = self.tiles.iter_mut();
        let tiles = tiles.filter(|(_, tile)| !tile.is_drawn || tile.is_target);
        let jobs = tiles.filter_map(|((image, content), tile)| {
            let view = images.get(*image)?.texture_view.clone();
            tile.is_drawn = true;
            let cells = content.cells();
            let (content, cutoff) = content.code();
            let job = TileJob {
                size: tile.place.size,
                first: tile.place.first,
                level: tile.level,
                content,
                cutoff,
                grid: cells.grid,
                columns: cells.columns,
                rows: cells.rows,
                faces: cells.faces,
            };
            Some((view, job))
        });
        jobs.collect()
    }

    pub(crate) fn view(&self) -> Option<&TextureView> {
        self.texture.as_ref().map(|(_, view)| view)
    }

    pub(super) fn bytes(&self) -> u64 {
        4 * u64::from(ROW) * u64::from(self.rows())
    }
}

/// The tiles of the textures of lights. The texture that holds them exists only while a light has one.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn palettes_are_exact_and_large_textures_small() {
        for (size, expected) in [
            ([256, 1], [256, 1]),
            ([1, 1], [1, 1]),
            ([40, 50], [40, 50]),
            ([64, 64], [32, 32]),
            ([4096, 4096], [32, 32]),
            ([4096, 2048], [32, 32]),
            ([16384, 1], [2048, 1]),
        ] {
            assert_eq!(tile_size(size.into()), UVec2::from(expected), "{size:?}");
        }
        for size in 1..300 {
            let tile = tile_size(UVec2::new(size, 7 * size));
            assert!(4 * texels_of(tile) <= 11 << 10, "{tile}");
        }
    }

    #[test]
    fn sources_are_read_at_a_level_with_few_texels() {
        let tile = UVec2::new(64, 32);
        assert_eq!(
            source_level(UVec2::splat(4096), 1, tile),
            0,
            "no other level"
        );
        assert_eq!(source_level(UVec2::splat(4096), 13, tile), 4);
        assert_eq!(source_level(UVec2::splat(64), 7, tile), 0);
    }

    #[test]
    fn no_texel_of_a_cube_has_parts_of_two_faces() {
        for (face, edge) in [(1, 1), (9, 8), (16, 16), (100, 16), (4096, 16)] {
            let mut size = cube_tile_size(UVec2::splat(face));
            assert_eq!(size, UVec2::new(edge, 6 * edge));
            assert!(size.element_product() <= MOST_TEXELS);
            while size.x > 1 {
                size /= 2;
                assert_eq!(size.y, 6 * size.x);
            }
        }
    }

    #[test]
    fn what_is_released_is_free_again() {
        let mut tiles = Tiles::default();
        for first in [300, 0, 100, 200] {
            tiles.release(first, 100);
        }
        assert_eq!(tiles.free, [(0, 400)]);
    }
}

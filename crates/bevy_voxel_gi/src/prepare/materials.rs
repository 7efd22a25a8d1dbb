//! The materials as the voxelisers read them, one record each in a texture: a pass cannot bind another storage buffer.

use bevy::{
    platform::collections::HashSet,
    prelude::*,
    render::{
        render_asset::RenderAssets,
        render_resource::{
            Extent3d, TexelCopyBufferLayout, Texture, TextureFormat, TextureUsages, TextureView,
            TextureViewDescriptor,
        },
        renderer::{RenderDevice, RenderQueue},
        texture::GpuImage,
    },
};

use super::{
    asset_notes::AssetNotes,
    buffers::texture,
    mesh_batches::MeshBatches,
    tiles::{NoTile, TileContent, TilePlace, Tiles, address_code},
};
use crate::{
    extract::{
        meshes::ExtractedScene,
        place_volume::ExtractedVolume,
        voxel_material::{VoxelAlpha, VoxelMaterial, VoxelTexture},
    },
    passes::kernel::chosen,
    settings::VoxelAlbedo,
};

// The layout of a record; keep in sync with `materials.wesl`.
const TEXELS: usize = 6;
const IN_ROW: usize = 128;
const DOUBLE_SIDED: u32 = 1;
const BASE_COLOR: u32 = 2;
const BASE_ALPHA: u32 = 4;
const EMISSIVE_MAP: u32 = 8;
const METALLIC_MAP: u32 = 16;
const VERTEX_COVERAGE: u32 = 32;
const HOLES: u32 = 64;
const NO_VERTEX_COLORS: u32 = 128;
const UNLIT: u32 = 256;

type Record = [u32; 4 * TEXELS];

/// The records, and what the passes have to know of them.
#[derive(Resource, Default)]
pub(crate) struct MaterialRecords {
    /// The state from which they were made.
    source: Option<Source>,
    words: Vec<u32>,
    texture: Option<(Texture, TextureView)>,
    /// Increases when a surface may have another colour.
    pub(super) version: u64,
    /// The materials that have changed since the scene was voxelised last.
    pub(super) changed: HashSet<u32>,
    /// Whether a material in use has a texture.
    pub has_textures: bool,
    /// Whether one has holes, and whether the alpha of a texture cuts them out.
    has_holes: bool,
    has_textured_holes: bool,
    /// The unit of the emission of surfaces, in exposed units; 0 if nothing emits.
    pub emission_unit: f32,
    /// Whether the light depends on the camera's exposure.
    pub(super) depends_on_exposure: bool,
}

/// The state from which records are made, except images.
#[derive(PartialEq)]
struct Source {
    materials: Option<u64>,
    used: Vec<u32>,
    neutral: bool,
    /// The exposure, where records depend on it.
    exposure: Option<u32>,
}

impl MaterialRecords {
    pub(crate) fn view(&self) -> Option<&TextureView> {
        self.texture.as_ref().map(|(_, view)| view)
    }

    pub(super) fn bytes(&self) -> u64 {
        let texture = self.texture.as_ref();
        let rows = texture.map_or(0, |(texture, _)| texture.height());
        (16 * TEXELS * IN_ROW) as u64 * u64::from(rows)
    }

    /// The shader defs of the two passes of voxelisation.
    pub(crate) fn defs(&self) -> [Vec<&'static str>; 2] {
        [
            [
                (self.has_holes, "HOLES"),
                (self.has_textured_holes, "TEXTURES"),
            ],
            [
                (self.has_textures, "TEXTURES"),
                (self.emission_unit > 0.0, EMISSION),
            ],
        ]
        .map(chosen)
    }

    fn upload(&mut self, device: &RenderDevice, queue: &RenderQueue) {
        let rows = self.words.len().div_ceil(4 * TEXELS * IN_ROW).max(1);
        self.words.resize(rows * 4 * TEXELS * IN_ROW, 0);
        let size = Extent3d {
            width: (TEXELS * IN_ROW) as u32,
            height: rows as u32,
            depth_or_array_layers: 1,
        };
        let is_other = |(texture, _): &(Texture, TextureView)| texture.height() != size.height;
        if self.texture.as_ref().is_none_or(is_other) {
            let size = [size.width, size.height, 1];
            let usage = TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST;
            let format = TextureFormat::Rgba32Uint;
            let texture = texture(device, "voxel_gi_materials", size, format, usage);
            let view = texture.create_view(&TextureViewDescriptor::default());
            self.texture = Some((texture, view));
        }
        if let Some((texture, _)) = &self.texture {
            let bytes = bytemuck::cast_slice(&self.words);
            let layout = TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(16 * size.width),
                rows_per_image: None,
            };
            queue.write_texture(texture.as_image_copy(), bytes, layout, size);
        }
    }
}

/// The shader def of the passes that know of emission.
pub(crate) const EMISSION: &str = "EMISSION";

/// Makes the records of the materials whose meshes reach into a level, and asks for the tiles of their textures.
pub(crate) fn prepare_materials(
    mut records: ResMut<MaterialRecords>,
    mut tiles: ResMut<Tiles>,
    (volume, scene, batches): (Res<ExtractedVolume>, Res<ExtractedScene>, Res<MeshBatches>),
    (images, notes): (Res<RenderAssets<GpuImage>>, Res<AssetNotes>),
    (device, queue): (Res<RenderDevice>, Res<RenderQueue>),
) {
    let Some(volume) = &volume.0 else {
        if records.source.is_some() {
            *records = MaterialRecords::default();
            *tiles = Tiles::default();
        }
        return;
    };
    let neutral = volume.settings.albedo == VoxelAlbedo::Neutral;
    let used: Vec<u32> = (0..scene.materials.len() as u32)
        .filter(|material| batches.uses(*material))
        .collect();
    let of_used = || used.iter().map(|i| &scene.materials[*i as usize]);
    let is_exposed = |material: &VoxelMaterial| weight(material) > 0.0;
    let source = Source {
        materials: scene.materials_version,
        neutral,
        exposure: of_used()
            .any(is_exposed)
            .then_some(volume.exposure.to_bits()),
        used: used.clone(),
    };
    let is_same = records.source.as_ref() == Some(&source);
    let has_images = images.is_changed() || !notes.uploaded.is_empty();
    if is_same && !(has_images && (records.has_textures || tiles.is_waiting)) {
        return;
    }
    let brightest = of_used()
        .map(|material| exposed_emission(material, volume.exposure).max_element())
        .fold(0.0, f32::max);
    let unit = if brightest > 0.0 {
        brightest.log2().ceil().exp2()
    } else {
        0.0
    };
    let mut drawn_anew = HashSet::<u32>::default();
    let mut words = vec![0; 4 * TEXELS * scene.materials.len()];
    tiles.begin();
    for &i in &used {
        let assets = (&*images, &*notes, &*device);
        let mut tile = |texture: VoxelTexture, content| {
            let tile = tiles.of((texture.image, content), assets);
            let (place, is_new) = tile.inspect_err(warn_of_missing_tile).ok()?;
            if is_new {
                drawn_anew.insert(i);
            }
            Some(place)
        };
        let mut record = RecordWriter {
            notes: &notes,
            tile: &mut tile,
            words: [0; 4 * TEXELS],
        };
        record.write(&scene.materials[i as usize], neutral, volume.exposure, unit);
        let first = 4 * TEXELS * i as usize;
        words[first..first + 4 * TEXELS].copy_from_slice(&record.words);
    }
    tiles.end();
    let flags = |mask: u32| {
        words
            .chunks_exact(4 * TEXELS)
            .any(|record| record[3] & mask != 0)
    };
    records.has_textures = flags(BASE_COLOR | BASE_ALPHA | EMISSIVE_MAP | METALLIC_MAP);
    records.has_holes = flags(HOLES);
    records.has_textured_holes = flags(BASE_ALPHA);
    records.emission_unit = unit;
    records.depends_on_exposure = unit > 0.0 && of_used().any(|material| weight(material) < 1.0);
    records.source = Some(source);
    let is_new = records.texture.is_none();
    let former = &records.words;
    let is_same = |i: usize| {
        let record = &words[i..i + 4 * TEXELS];
        // Room at the end is 0, as the records of materials that are not in use.
        former
            .get(i..i + 4 * TEXELS)
            .map_or(record.iter().all(|word| *word == 0), |former| {
                former == record
            })
    };
    let of_records = (0..words.len()).step_by(4 * TEXELS);
    let changed = of_records.filter(|i| !is_same(*i));
    let changed: Vec<_> = changed.map(|i| (i / (4 * TEXELS)) as u32).collect();
    if is_new || !changed.is_empty() || !drawn_anew.is_empty() {
        records.version += 1;
    }
    if is_new || !changed.is_empty() {
        records.words = words;
        records.upload(&device, &queue);
    }
    records.changed.extend(changed);
    records.changed.extend(drawn_anew);
}

fn warn_of_missing_tile(reason: &NoTile) {
    match reason {
        NoTile::NotLoaded => (),
        NoTile::Unreadable(format, dimension) => warn_once!(
            "voxel GI: a texture of the format {format:?} and dimension {dimension:?} cannot be read by the voxelisers, so \
             its material has no texture for them. Use two-dimensional colour images"
        ),
        NoTile::NoRoom(bytes) => warn_once!(
            "voxel GI: the textures of materials take more than the {} MiB that this device has for them, so some \
             materials have none for the voxelisers. Use fewer textures",
            bytes >> 20
        ),
    }
}

/// Weight of the exposure in what a material emits; 0 if it emits nothing.
fn weight(material: &VoxelMaterial) -> f32 {
    if material.unlit || emission(material) == Vec3::ZERO {
        return 0.0;
    }
    material.emissive_exposure_weight.clamp(0.0, 1.0)
}

fn emission(material: &VoxelMaterial) -> Vec3 {
    // An unlit material shows its colour whatever the exposure, as an emission of weight 0 does.
    let emission = if material.unlit {
        material.base_color.to_vec3()
    } else {
        material.emissive
    };
    finite(emission * material.emission_factor).max(Vec3::ZERO)
}

/// Emission times the exposure, as far as the exposure counts.
fn exposed_emission(material: &VoxelMaterial, exposure: f32) -> Vec3 {
    emission(material) * 1.0.lerp(exposure, weight(material))
}

fn finite(v: Vec3) -> Vec3 {
    if v.is_finite() { v } else { Vec3::ZERO }
}

pub(super) fn flag(is_on: bool, flag: u32) -> u32 {
    if is_on { flag } else { 0 }
}

/// Writes a record.
struct RecordWriter<'a> {
    notes: &'a AssetNotes,
    tile: &'a mut dyn FnMut(VoxelTexture, TileContent) -> Option<TilePlace>,
    words: Record,
}

impl RecordWriter<'_> {
    fn floats(&mut self, first: usize, floats: &[f32]) {
        for (word, float) in self.words[first..].iter_mut().zip(floats) {
            *word = float.to_bits();
        }
    }

    /// Writes where a map is; returns whether it is there.
    fn map(&mut self, map: usize, texture: VoxelTexture, content: TileContent) -> bool {
        const FIRST: [usize; 3] = [15, 16, 18];
        const SIZE: [usize; 3] = [20, 17, 19];
        let Some(place) = (self.tile)(texture, content) else {
            return false;
        };
        self.words[FIRST[map]] = place.first;
        self.words[SIZE[map]] = place.size.x | place.size.y << 16;
        let [u, v] = self.notes.address(texture.image).map(address_code);
        let channel = u32::from(texture.uses_uv_1);
        self.words[22] |= (u | v << 2 | channel << 4) << (5 * map);
        true
    }

    fn write(&mut self, material: &VoxelMaterial, neutral: bool, exposure: f32, unit: f32) {
        let ignores_colors = material.ignores_colors || neutral;
        let mut flags = flag(material.double_sided, DOUBLE_SIDED);
        flags |= flag(ignores_colors, NO_VERTEX_COLORS);
        flags |= flag(material.unlit, UNLIT);
        let mut color = if neutral {
            VoxelMaterial::NEUTRAL.base_color.to_vec3()
        } else {
            finite(material.base_color.to_vec3())
        };
        let alpha = finite(Vec3::splat(material.base_color.alpha)).x.max(0.0);
        // The opaque fraction without textures, and the least alpha of vertices.
        let (mut coverage, mut least_alpha) = (1.0, 0.0);
        let content = match material.alpha {
            VoxelAlpha::Mask(cutoff) if cutoff > 0.0 => {
                let relative = cutoff / alpha;
                flags |= HOLES;
                least_alpha = relative;
                TileContent::Masked((255.0 * relative).ceil().clamp(1.0, 256.0) as u16)
            }
            VoxelAlpha::Coverage => {
                flags |= HOLES | VERTEX_COVERAGE;
                coverage = alpha.min(1.0);
                TileContent::Covered
            }
            VoxelAlpha::Constant(constant) if constant < 1.0 => {
                flags |= HOLES;
                coverage = constant.max(0.0);
                TileContent::Color
            }
            _ => TileContent::Color,
        };
        if let Some(texture) = material.base_color_texture
            && !(ignores_colors && content == TileContent::Color)
        {
            if self.map(0, texture, content) {
                flags |= flag(!ignores_colors, BASE_COLOR);
                flags |= flag(content != TileContent::Color, BASE_ALPHA);
            } else if !ignores_colors {
                // It is not there yet.
                color *= 0.5;
            }
        }
        let mut metallic = if material.metallic.is_finite() && !neutral {
            material.metallic.clamp(0.0, 1.0)
        } else {
            0.0
        };
        if let Some(texture) = material.metallic_texture
            && metallic > 0.0
        {
            if self.map(2, texture, TileContent::Color) {
                flags |= METALLIC_MAP;
            } else {
                metallic = 0.0;
            }
        }
        if flags & METALLIC_MAP == 0 {
            color *= 1.0 - metallic;
        }
        let mut emission = exposed_emission(material, exposure);
        let texture = if material.unlit {
            color = if neutral { color } else { Vec3::ZERO };
            material.base_color_texture
        } else {
            material.emissive_texture
        };
        if let Some(texture) = texture
            && emission != Vec3::ZERO
        {
            if self.map(1, texture, TileContent::Emission) {
                flags |= EMISSIVE_MAP;
            } else {
                emission = Vec3::ZERO;
            }
        }
        let emission = if unit > 0.0 {
            emission / unit
        } else {
            Vec3::ZERO
        };
        let color = color.clamp(Vec3::ZERO, Vec3::ONE);
        self.floats(0, &color.to_array());
        self.words[3] = flags;
        self.floats(4, &emission.to_array());
        self.floats(7, &[metallic]);
        let transform = if material.uv_transform.is_finite() {
            material.uv_transform
        } else {
            bevy::math::Affine2::IDENTITY
        };
        self.floats(8, &transform.to_cols_array());
        self.floats(14, &[coverage]);
        self.floats(23, &[least_alpha]);
    }
}

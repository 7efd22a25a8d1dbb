//! Hashes of everything that the light depends on: a change of the hash is a change of the light.

use std::hash::{BuildHasher, Hash, Hasher};

use bevy::{color::ColorToComponents, platform::hash::FixedHasher};

use crate::{
    extract::placement::{PlacedLevel, PlacedVolume},
    gpu_types::Light,
    prepare::materials::MaterialRecords,
    settings::Voxelizer,
};

/// Adds floats to a hash by their bits, so that NaN equals itself.
pub(crate) fn hash_floats<const N: usize>(hasher: &mut impl Hasher, floats: &[f32; N]) {
    u32::hash_slice(&floats.map(f32::to_bits), hasher);
}

/// Hash of what the voxels depend on; `meshes` is that of the meshes.
pub(super) fn voxel_fingerprint(meshes: u64, volume: &PlacedVolume) -> u64 {
    let mut hasher = FixedHasher.build_hasher();
    meshes.hash(&mut hasher);
    for level in &volume.levels {
        hash_floats(&mut hasher, &level.center.to_array());
        hash_floats(&mut hasher, &[level.size]);
    }
    match volume.settings.voxelizer {
        Voxelizer::Conservative => 0,
        Voxelizer::FragmentClipping => 1,
        Voxelizer::GeometryClipping => 2,
        Voxelizer::Stochastic { points } => 3 + u64::from(points),
    }
    .hash(&mut hasher);
    hasher.finish()
}

/// Hashes of what the light depends on, except the settings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Fingerprint {
    /// That of the scene, and of the colours that cameras see.
    pub scene: u64,
    /// That of where the levels are.
    pub places: u64,
}

/// `meshes` is the hash of the meshes.
pub(super) fn fingerprint(
    meshes: u64,
    volume: &PlacedVolume,
    lights: &[Light],
    materials: &MaterialRecords,
    light_tiles_version: u64,
    sky_version: u64,
) -> Fingerprint {
    let mut hasher = FixedHasher.build_hasher();
    let mut places = FixedHasher.build_hasher();
    (meshes, materials.version, light_tiles_version).hash(&mut hasher);
    (sky_version, volume.sky_revision).hash(&mut hasher);
    for level in &volume.levels {
        let PlacedLevel {
            owner: _,
            center,
            // Only pixels notice.
            focus: _,
            step: _,
            size,
            sky,
            intensity,
            sees_map,
            is_outer: _,
        } = level;
        hash_floats(&mut places, &center.to_array());
        hash_floats(&mut hasher, &[*size, *intensity]);
        sees_map.hash(&mut hasher);
        for color in [sky.zenith, sky.horizon, sky.ground] {
            hash_floats(&mut hasher, &color.to_f32_array());
        }
    }
    for viewpoint in &volume.viewpoints {
        hash_floats(&mut hasher, &viewpoint.to_matrix().to_cols_array());
    }
    for light in lights {
        hash_floats(&mut hasher, &light.position.to_array());
        hash_floats(&mut hasher, &light.color.to_array());
        hash_floats(&mut hasher, &light.direction.to_array());
        hash_floats(&mut hasher, &light.half_width.to_array());
        hash_floats(&mut hasher, &light.half_height.to_array());
        let others = [
            light.inverse_range_squared,
            light.spot_scale,
            light.spot_offset,
            light.near,
        ];
        hash_floats(&mut hasher, &others);
        light.kind.hash(&mut hasher);
        (light.tile_first, light.tile_size, light.tile_address).hash(&mut hasher);
    }
    if materials.depends_on_exposure {
        hash_floats(&mut hasher, &[volume.exposure]);
    }
    Fingerprint {
        scene: hasher.finish(),
        places: places.finish(),
    }
}
